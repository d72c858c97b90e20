"""Films of trials as GIF or pictures."""
