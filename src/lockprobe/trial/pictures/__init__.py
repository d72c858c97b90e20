"""Images as arrays and files: colour, depth, degradation, and reading positions from them."""
