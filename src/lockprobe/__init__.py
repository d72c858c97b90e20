"""Lockprobe: a laboratory for probing the behaviour of embodied agents.

>>> import lockprobe
>>> lockprobe.box("chain-4").target
'revolute-left'
>>> trial = lockprobe.run_trial(agent="human-inspired", p=0.0, seed=1)
>>> trial.solved
True

``tidy_rows`` gives one row a step, ``trial_rows`` one row a trial:
``pandas.DataFrame(lockprobe.tidy_rows(lockprobe.load(directory)))``.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from lockprobe.environment import announce

if TYPE_CHECKING:
    from lockprobe.export import tidy_rows, trial_rows
    from lockprobe.lockbox.families import box
    from lockprobe.report.schema import results
    from lockprobe.studies.journal import load
    from lockprobe.studies.montecarlo import population, propagate
    from lockprobe.studies.runner import run_study
    from lockprobe.studies.single import run_trial
    from lockprobe.studies.studyfile import study

__all__ = [
    "__version__",
    "box",
    "load",
    "population",
    "propagate",
    "results",
    "run_study",
    "run_trial",
    "study",
    "tidy_rows",
    "trial_rows",
]

_HOMES = {
    "box": "lockprobe.lockbox.families",
    "load": "lockprobe.studies.journal",
    "population": "lockprobe.studies.montecarlo",
    "propagate": "lockprobe.studies.montecarlo",
    "results": "lockprobe.report.schema",
    "run_study": "lockprobe.studies.runner",
    "run_trial": "lockprobe.studies.single",
    "study": "lockprobe.studies.studyfile",
    "tidy_rows": "lockprobe.export",
    "trial_rows": "lockprobe.export",
}


announce()  # a Gymnasium that is loaded, or will be, knows lockprobe/Lockbox-v0; none is loaded here


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def __getattr__(name: str) -> object:
    """Public names are imported when they are first used, so that ``lockprobe --help`` stays quick."""
    if name == "__version__":
        from importlib.metadata import version

        return version("lockprobe")
    if name not in _HOMES:
        raise AttributeError(f"module 'lockprobe' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
