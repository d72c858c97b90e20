"""Cognitive models fitted to an agent's choices, and how well they predict."""

from lockprobe.simulation.fit.candidate_models import RIVALS
from lockprobe.simulation.fit.fitting import fit_agents
from lockprobe.simulation.fit.result import AgentFit, FitReport, Parameter, Predicted, RivalFit

__all__ = ["RIVALS", "AgentFit", "FitReport", "Parameter", "Predicted", "RivalFit", "fit_agents"]
