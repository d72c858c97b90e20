"""Tests and intervals that hold at every look: e-processes and confidence sequences."""
