"""How an HTTP server of this package listens, runs and stops, and what its connections may do; no application."""
