"""Contracts as functions, and trials made by hand: for the tests of whoever writes a part of their own.

::

    from lockprobe.testing import check_agent, check_intervention

    def test_late():
        check_intervention(Late(lag=2))

    def test_stubborn():
        check_agent("stubborn?tries=3")

Where pytest is used, the same are fixtures of these names (:mod:`lockprobe.pytest_plugin`).
"""

from __future__ import annotations

from lockprobe.testing.agents import check_agent
from lockprobe.testing.boxes import check_box
from lockprobe.testing.interventions import check_intervention
from lockprobe.testing.measures import check_measure
from lockprobe.testing.plants import check_plant
from lockprobe.testing.trials import ScriptedAgent, make_trial, play_trials

__all__ = [
    "ScriptedAgent",
    "check_agent",
    "check_box",
    "check_intervention",
    "check_measure",
    "check_plant",
    "make_trial",
    "play_trials",
]
