"""Very many trials of a policy without records, and its exact course without any trial."""

from lockprobe.studies.montecarlo.populations import Population, population
from lockprobe.studies.montecarlo.propagation import Propagation, propagate

__all__ = ["Population", "Propagation", "population", "propagate"]
