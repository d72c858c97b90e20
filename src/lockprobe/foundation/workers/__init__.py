"""Workers: the same jobs in processes of this machine, or on the processors of a cluster, with the same results."""

from lockprobe.foundation.workers.cluster import Cluster
from lockprobe.foundation.workers.pool import Lost, Pool
from lockprobe.foundation.workers.processes import Processes, lose

__all__ = ["Cluster", "Lost", "Pool", "Processes", "lose"]
