"""Films of trials as GIF, MP4 or pictures."""
