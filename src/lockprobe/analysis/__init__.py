"""Trials in, numbers out."""
