"""Studies side by side, and their page."""
