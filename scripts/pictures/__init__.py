"""What scripts/doc_pictures.py draws, one file for each kind of page."""
