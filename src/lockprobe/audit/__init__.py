"""Is each test right? Simulated agents with known truth go through the whole pipeline."""
