"""Monte Carlo simulation of policies: millions of trials without records."""
