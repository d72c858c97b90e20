"""Fractional factorial designs: many factors of two levels at once, in a part of their combinations."""
