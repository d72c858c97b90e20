"""Contract tests, builders and fakes for the tests of a package that extends Lockprobe.

::

    from lockprobe.testing import check_agent, check_intervention

    def test_late():
        check_intervention(Late(lag=2))

    def test_stubborn():
        check_agent("stubborn?tries=3")
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lockprobe.testing.agents import check_agent
    from lockprobe.testing.boxes import check_box
    from lockprobe.testing.interventions import check_intervention
    from lockprobe.testing.measures import check_measure
    from lockprobe.testing.plants import PlantTried, check_plant
    from lockprobe.testing.provider import ScriptedProvider, completion, failure, in_turn, joints, replying, words
    from lockprobe.testing.trials import ScriptedAgent, make_trial, play_trials

__all__ = [
    "PlantTried",
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

_HOMES = {
    **{f"check_{kind}": f"{kind}s" for kind in ("agent", "intervention", "measure", "plant")},
    "PlantTried": "plants",
    "check_box": "boxes",
    **dict.fromkeys(
        ("ScriptedProvider", "completion", "failure", "in_turn", "joints", "replying", "words"), "provider"
    ),
    **dict.fromkeys(("ScriptedAgent", "make_trial", "play_trials"), "trials"),
}
"""Public name -> its module here: each is imported when it is first used."""


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'lockprobe.testing' has no attribute {name!r}")
    return getattr(import_module(f"lockprobe.testing.{_HOMES[name]}"), name)
