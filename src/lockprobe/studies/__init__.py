"""Studies: their settings, the journal of finished trials, and the runner between them."""
