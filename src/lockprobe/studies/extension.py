"""A study that becomes larger than it was when its trials began."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import PEOPLE
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.options.sizes import sized_as_there
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.store import holds_records
from lockprobe.studies.study import Study
from lockprobe.studies.until import EarlierSize


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
