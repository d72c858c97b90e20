"""Lockprobe: a laboratory for probing the behaviour of embodied agents.

>>> import lockprobe
>>> lockprobe.box("chain-4").target
'revolute-left'
>>> trial = lockprobe.run_trial(agent="human-inspired", p=0.0, seed=1)
>>> trial.solved
True

``tidy`` gives one row a step, ``trial_rows`` one row a trial: ``pandas.DataFrame(lockprobe.tidy(trials))``. What one
needs to write an agent, a plant, a box, an intervention or a measure is here too (docs/extending.md).
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lockprobe.agents.policy import Policy
    from lockprobe.boxes.box import Joint, Lockbox
    from lockprobe.boxes.families import find_box as box
    from lockprobe.foundation.errors import BadValue, LockprobeError, TrialFault, UserMistake
    from lockprobe.interfaces.export import tidy, trial_rows
    from lockprobe.report.results import results
    from lockprobe.simulation.exact import propagate
    from lockprobe.simulation.kernel import population
    from lockprobe.studies.options.studyfile import study
    from lockprobe.studies.records.read_records import load
    from lockprobe.studies.running.runner import run_study
    from lockprobe.studies.running.single import run_trial
    from lockprobe.studies.study import Study
    from lockprobe.trial.protocols import Actuator, Agent, Channel, Memory, Plant, Prompt
    from lockprobe.trial.record import Decision, Percept, Situation, Snapshot, Step, Trial

__all__ = [
    "Actuator",
    "Agent",
    "BadValue",
    "Channel",
    "Decision",
    "Joint",
    "Lockbox",
    "LockprobeError",
    "Memory",
    "Percept",
    "Plant",
    "Policy",
    "Prompt",
    "Situation",
    "Snapshot",
    "Step",
    "Study",
    "Trial",
    "TrialFault",
    "UserMistake",
    "__version__",
    "box",
    "load",
    "population",
    "propagate",
    "results",
    "run_study",
    "run_trial",
    "study",
    "tidy",
    "trial_rows",
]

_NAMES = {
    "agents.policy": "Policy",
    "boxes.box": "Joint Lockbox",
    "foundation.errors": "BadValue LockprobeError TrialFault UserMistake",
    "interfaces.export": "tidy trial_rows",
    "report.results": "results",
    "simulation.exact": "propagate",
    "simulation.kernel": "population",
    "studies.records.read_records": "load",
    "studies.running.runner": "run_study",
    "studies.running.single": "run_trial",
    "studies.study": "Study",
    "studies.options.studyfile": "study",
    "trial.protocols": "Actuator Agent Channel Memory Plant Prompt",
    "trial.record": "Decision Percept Situation Snapshot Step Trial",
}
"""Module -> the public names that it has."""

_HOMES = {name: f"lockprobe.{module}" for module, names in _NAMES.items() for name in names.split()}
_HOMES["box"] = "lockprobe.boxes.families:find_box"
"""Public name -> its module, and its name there where that is another one."""

if "gymnasium" in sys.modules:  # as for gymnasium.make("lockprobe:lockprobe/Lockbox-v0"), which imports this module
    import_module("lockprobe.interfaces.gymnasium")


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES, *__all__})


def __getattr__(name: str) -> object:
    """Public names are imported when they are first used, so that ``lockprobe --help`` stays quick."""
    if name == "__version__":
        from importlib.metadata import version

        return version("lockprobe")
    if name not in _HOMES:
        raise AttributeError(f"module 'lockprobe' has no attribute {name!r}")
    module, _, other = _HOMES[name].partition(":")
    return getattr(import_module(module), other or name)
