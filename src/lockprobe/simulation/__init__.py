"""Agents as models: many trials without records, exact success curves, error rates of tests, fits to choices."""
