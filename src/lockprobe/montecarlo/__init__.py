"""Very many trials of a policy without records, and its exact course without any trial."""

from lockprobe.montecarlo.populations import Population, population
from lockprobe.montecarlo.propagation import Propagation, propagate

__all__ = ["Population", "Propagation", "population", "propagate"]
