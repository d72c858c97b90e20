"""What a study costs: estimates, budgets, spending, calls."""
