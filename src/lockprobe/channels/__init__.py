"""What may be seen: each channel turns a percept into what is passed on."""
