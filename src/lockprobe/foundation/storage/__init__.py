"""Files on disk: atomic replacement, append-only JSON lines with checksums."""
