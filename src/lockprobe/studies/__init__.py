"""Studies: what is to be played, the journal of what was, and the runner between them."""
