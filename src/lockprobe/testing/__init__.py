"""Contract tests, builders and fakes for the tests of a package that extends Lockprobe.

::

    from lockprobe.testing import check_agent, check_intervention

    def test_late():
        check_intervention(Late(lag=2))

    def test_stubborn():
        check_agent("stubborn?tries=3")
"""

from __future__ import annotations

from lockprobe.testing.contracts import check_agent, check_box, check_intervention, check_measure, check_plant
from lockprobe.testing.provider import ScriptedProvider, completion, failure, in_turn, joints, replying, words
from lockprobe.testing.trials import ScriptedAgent, make_trial, play_trials

__all__ = [
    "ScriptedAgent",
    "ScriptedProvider",
    "check_agent",
    "check_box",
    "check_intervention",
    "check_measure",
    "check_plant",
    "completion",
    "failure",
    "in_turn",
    "joints",
    "make_trial",
    "play_trials",
    "replying",
    "words",
]
