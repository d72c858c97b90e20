"""Exact probabilities of what a policy does, without playing trials."""
