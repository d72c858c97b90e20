"""The scores of a suite of studies, and ranks."""
