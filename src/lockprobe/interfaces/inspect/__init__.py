"""Inspect AI: runs studies as tasks, writes trials as logs, and reads logs back."""
