"""Priors over interlocks, the exact posterior given reports, and plans under it."""
