"""Statistical inference: the paper's statistics, and tests that keep their error rates."""
