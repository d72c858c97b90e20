"""The scores and the page of a suite."""
