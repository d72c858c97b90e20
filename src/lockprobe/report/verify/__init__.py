"""Recomputing a study from its records."""
