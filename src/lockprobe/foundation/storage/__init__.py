"""Files on disk: atomic replacement, and one SQLite file with one writer."""
