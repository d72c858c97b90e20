"""What one can know of a box who knows only what was told: stated priors, the exact posterior, and plans by it."""
