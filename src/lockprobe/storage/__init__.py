"""Files on disk: atomic replacement, lines of JSON that survive a crash, checksums."""
