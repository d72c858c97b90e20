"""The audit: false-positive rates and power of every test, on simulated agents with known truth."""
