"""Directories and files as somebody else may send them: every name in them that can name code names code.

The code is a canary: a module of the working directory that leaves a file when it is imported, and a shell command that
leaves one when it is called.
"""

import json
import shutil
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from builders import play_study, write_study
from stored import rewrite
from strangers import WORKING

from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import flips
from lockprobe.interventions.told import Drop
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition, Recorded
from lockprobe.trial.trial_json import trial_to_json

MODULE = "canary"

SUNG = "it-ran"
"""The file that any code of the canary leaves in the working directory."""

CALL = f"python:os:system?command=touch%20{SUNG}"

AGENTS = (CALL, f"python:{MODULE}:First?place=1")
PLANT = f"python:{MODULE}:Plain"
ACTING = f"python:{MODULE}:Hush?steps=1"

KINDS = ("agents", "plant", "condition")
"""What of a directory names code."""


def hatch(here: Path) -> None:
    """Put the module into the working directory."""
    text = f"import pathlib\npathlib.Path({str(here / SUNG)!r}).touch()\n{WORKING}"
    (here / f"{MODULE}.py").write_text(text, "utf-8")


def directory(path: Path, kind: str) -> Path:
    """The directory of a study that names code. Each agent owes its last trial."""
    return Path(shutil.copytree(_made(kind).name, path, dirs_exist_ok=True))


@cache
def _made(kind: str) -> TemporaryDirectory[str]:
    made = TemporaryDirectory()
    path = Path(made.name)
    played = Study(name="flips", agents=("random",), boxes=(box("chain-4"),), conditions=flips((0.0, 0.4)), trials=2)
    if kind == "condition":
        played = replace(played, conditions=(Condition(), Condition(interventions=(Drop(p=0.5),), name="x")))
    trials = play_study(played)[:-1]
    named = played
    if kind == "condition":
        named = replace(played, conditions=(Condition(), Condition(interventions=(Recorded(spec=ACTING),), name="x")))
        trials = [replace(trial, specs=named.labelled(trial.condition).specs) for trial in trials]
    if kind == "plant":
        named = replace(played, plant=PLANT)
        trials = [replace(trial, plant={"plant": PLANT}) for trial in trials]
    if kind == "agents":
        named = replace(played, agents=AGENTS)
        trials = [
            replace(trial, agent=agent, key=str(replace(trial.name, agent=agent)))
            for agent in AGENTS
            for trial in trials
        ]
    write_study(path, replace(played, agents=("random",)), [])
    (path / "study.json").write_text(json.dumps(named.settings()))
    identities = [named.record_identity(named.labelled(trial.condition)) for trial in trials]
    rewrite(path, [json.loads(trial_to_json(trial)) for trial in trials], identities)
    return made


def study_files(here: Path) -> Sequence[Path]:
    """Study files that name code in every setting that can."""
    made = []
    for i, line in enumerate(
        [
            f'agent = ["random", "{CALL}"]',
            f'plant = "{PLANT}"',
            f'box = "python:{MODULE}:gate?size=5"',
            f'condition = "tremble?p=0.1 + {ACTING}"',
            f'sweep = "python:{MODULE}:Hush?steps=0,1"',
            f'[[condition]]\nname = "x"\nspec = "{ACTING}"',
        ]
    ):
        made.append(here / f"foreign-{i}.toml")
        made[-1].write_text(f"{line}\n", "utf-8")
    return made
