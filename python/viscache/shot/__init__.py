"""What to render, and rendering it."""
