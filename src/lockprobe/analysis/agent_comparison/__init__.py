"""Agents side by side: paired on the same boxes with the same false reports."""
