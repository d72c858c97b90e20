"""A study that is asked for where a directory holds it already: its size, and how it grew."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import PEOPLE
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.store import holds_records
from lockprobe.studies.study import SIZES, Study
from lockprobe.studies.until import EarlierSize

SIZE_OPTIONS = frozenset({"trials", "repetitions", "strategy_trials", "full", "until", "most"})
"""The options that say how much is played."""


def sized_as_there(planned: Study, there: Study, said: Collection[str]) -> Study:
    """A study with what was not said of its size as its directory has it.

    Args:
        planned: The study as it was asked for.
        there: The study of its directory.
        said: The options that were given, of :data:`SIZE_OPTIONS` and others.
    """
    said = SIZE_OPTIONS & {*said}
    if not said:
        return replace(planned, **{name: getattr(there, name) for name in SIZES})
    if "full" in said:
        return planned
    if planned.until is not None:
        return _until_there(planned, there, said)
    trials = planned.trials if "trials" in said else there.trials
    more = planned.strategy_trials
    if "strategy_trials" not in said:
        more = there.strategy_trials and max(there.strategy_trials, trials)
    return replace(
        planned,
        repetitions=planned.repetitions if "repetitions" in said else there.repetitions,
        trials=trials,
        strategy_trials=more,
    )


def _until_there(planned: Study, there: Study, said: Collection[str]) -> Study:
    """A study that stops, in the repetitions of its directory, since its trials are numbered within them.

    It plays at most what was said, in whole repetitions; else what its directory allows, or as many as by default.
    """
    each = max(1, planned.trials // there.repetitions)
    if "most" not in said:
        each = there.trials if there.until else max(each, there.trials)
    more = there.strategy_trials if there.strategy_trials and there.strategy_trials > each else None
    return replace(planned, repetitions=there.repetitions, trials=each, strategy_trials=more)


def extended(planned: Study, directory: Path) -> Study:
    """A study with the sizes that its directory had before, the present one too if the new one is larger.

    Trials that are added after a look are valid if everything is then tested at every look. The sizes say in which
    order blocks were planned.

    Args:
        planned: The study as it is asked for now.
        directory: Its directory, which may be new.

    Returns:
        The study; as it was where it is no larger, or where no trial was begun. One that stops when it is decided keeps
        the repetitions of its directory, within which its trials are numbered.

    Raises:
        BadValue: If people take part, who are compared at one look.
    """
    if not (directory / SETTINGS).exists():
        return planned
    there = read_study(directory)
    if planned.until and planned.repetitions == 1 < there.repetitions:
        planned = sized_as_there(planned, there, {"until", "most"})
    old, new = ([one.repetitions, one.trials, *map(one.trials_of, there.agents)] for one in (there, planned))
    if any(more < less for more, less in zip(new, old, strict=True)):
        return planned
    planned = replace(planned, earlier=there.earlier)
    if _size(there) == _size(planned) or not holds_records(directory):
        return planned
    if PEOPLE in {*there.agents, *planned.agents}:
        raise BadValue("trials", planned.trials, f"{there.trials}: people are compared at one look, at a fixed number")

    before = EarlierSize(there.repetitions, there.trials, there.strategy_trials)
    return replace(planned, earlier=(*there.earlier, before))


def _size(study: Study) -> tuple[object, ...]:
    return study.repetitions, study.trials, study.strategy_trials, study.until
