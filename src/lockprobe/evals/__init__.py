"""Inspect AI: the studies as its tasks, any trials as its logs, and its logs read back."""
