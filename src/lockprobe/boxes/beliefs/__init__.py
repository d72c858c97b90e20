"""Bayesian beliefs about interlocks: priors, the exact posterior given reports, and planning under it."""
