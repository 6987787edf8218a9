"""Ground floor: arrays, files, formats, progress, threads; nothing of rendering."""
