"""Comparisons of agents: paired on the same boxes with the same false reports."""
