"""Monte Carlo simulation of policies: millions of trials without records, and exact probabilities."""

from lockprobe.montecarlo.excursions import LieEffects, lie_effects
from lockprobe.montecarlo.populations import Population, population
from lockprobe.montecarlo.propagation import Propagation, propagate

__all__ = ["LieEffects", "Population", "Propagation", "lie_effects", "population", "propagate"]
