"""Distributed work: jobs on the processors of a Ray cluster."""

from lockprobe.foundation.cluster.work import Cluster, Lost, Node

__all__ = ["Cluster", "Lost", "Node"]
