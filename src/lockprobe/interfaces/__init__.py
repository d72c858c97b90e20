"""Lockprobe in other tools: Gymnasium, Inspect AI, the Model Context Protocol, tables and data sets."""
