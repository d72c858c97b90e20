"""Error rates and power of every test, on simulated agents with known truth."""
