"""The settings of a study directory, and how they grow: a study that has been played can be extended."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from lockprobe.foundation.errors import BadFile, BadValue, UserMistake
from lockprobe.foundation.inputs import parse_json, read_input
from lockprobe.foundation.spec import PEOPLE
from lockprobe.foundation.validation import plain
from lockprobe.studies import SETTINGS
from lockprobe.studies.records.store import holds
from lockprobe.studies.study import AS_JSON, SIZES, EarlierSize, Study, settings_of


def read_study(directory: Path | str) -> Study:
    """The study whose settings lie in a directory.

    Raises:
        BadFile: If there are none, or they describe no study.
    """
    path = Path(directory) / SETTINGS
    if not path.exists():
        raise BadFile(directory, f"no {SETTINGS} here; is it the directory of a study?")
    said: Any = parse_json(text := read_input(path), path)
    try:
        study = AS_JSON.validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "settings"
        raise BadFile(path, f"{where}: {plain(first['msg'])}") from None
    except UserMistake as error:
        raise BadFile(path, str(error)) from None
    if other := [name for name, value in settings_of(study).items() if said.get(name) != value]:
        raise BadFile(path, f"{other[0]}: is missing, or not as lockprobe writes it")
    return study


def extended(planned: Study, directory: Path) -> Study:
    """A study with the sizes that its directory had before, the present one too if the new one is larger.

    Trials that are added after a look are valid if everything is then tested at every look. The sizes say in which
    order blocks were planned.

    Where it is no larger, or no trial was begun, it is as it was. One that stops when it is decided keeps the
    repetitions of its directory, within which its trials are numbered.

    Raises:
        BadValue: If people take part, who are compared at one look.
    """
    if not (directory / SETTINGS).exists():
        return planned
    there = read_study(directory)
    if planned.until and planned.repetitions == 1 < there.repetitions:
        each = max(1, planned.trials // there.repetitions)
        more = there.strategy_trials if there.strategy_trials and there.strategy_trials > each else None
        planned = replace(planned, repetitions=there.repetitions, trials=each, strategy_trials=more)
    old, new = ([one.repetitions, one.trials, *map(one.trials_of, there.agents)] for one in (there, planned))
    if any(more < less for more, less in zip(new, old, strict=True)):
        return planned
    planned = replace(planned, earlier=there.earlier)
    same = all(getattr(there, name) == getattr(planned, name) for name in SIZES)
    if same or not holds(directory, "trial", "call", "attempt"):
        return planned
    if PEOPLE in {*there.agents, *planned.agents}:
        raise BadValue("trials", planned.trials, f"{there.trials}: people are compared at one look, at a fixed number")
    before = EarlierSize(there.repetitions, there.trials, there.strategy_trials)
    return replace(planned, earlier=(*there.earlier, before))
