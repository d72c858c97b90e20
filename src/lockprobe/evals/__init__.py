"""Inspect AI: studies as its tasks, trials as its logs, and its logs read back."""
