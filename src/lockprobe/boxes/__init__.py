"""The lockbox puzzle: its rules, named boxes and exact solutions, without physics."""
