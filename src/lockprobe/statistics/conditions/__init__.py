"""Results of one condition and of all: designs, doses, effects, interactions."""
