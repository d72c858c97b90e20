"""The puzzle: pure rules, named boxes, exact facts."""
