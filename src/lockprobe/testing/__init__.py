"""Contract tests and builders for the tests of a package that extends Lockprobe.

::

    from lockprobe.testing import check_agent, check_intervention

    def test_late():
        check_intervention(Late(lag=2))

    def test_stubborn():
        check_agent("stubborn?tries=3")
"""

from __future__ import annotations

from lockprobe.testing.contracts import check_agent, check_box, check_intervention, check_measure, check_plant
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
