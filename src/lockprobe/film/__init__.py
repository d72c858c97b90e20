"""Films of trials, for people."""
