"""Lockprobe: a laboratory for probing the behaviour of embodied agents.

>>> import lockprobe
>>> lockprobe.box("chain-4").target
'revolute-left'
>>> trial = lockprobe.run_trial(agent="human-inspired", p=0.0, seed=1)
>>> trial.solved
True
"""

from __future__ import annotations

from importlib.metadata import version

from lockprobe.lockbox.families import box
from lockprobe.studies.journal import load
from lockprobe.studies.stage import run_trial
from lockprobe.studies.studyfile import study

__all__ = ["__version__", "box", "load", "run_trial", "study"]

__version__ = version("lockprobe")
