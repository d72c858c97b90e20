"""Monte Carlo simulation of policies: millions of trials without records, and exact probabilities."""

from lockprobe.simulation.montecarlo.excursions import LieEffects, lie_effects
from lockprobe.simulation.montecarlo.populations import Population, population
from lockprobe.simulation.montecarlo.propagation import Propagation, propagate

__all__ = ["LieEffects", "Population", "Propagation", "lie_effects", "population", "propagate"]
