"""Records of a study counted by agent and condition, and the conditions with which something is wrong.

Records that are alike but for their places are counted together in the store, without their steps. Those with what adds
up over steps, as usage, are read whole.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.storage.database import Database
from lockprobe.statistics.outcomes import ended
from lockprobe.studies.records.read_records import Own
from lockprobe.studies.records.trial_rows import trial_in
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial, TrialError
from lockprobe.trial.trial_reader import TrialReader


@dataclass(frozen=True, slots=True)
class Counted:
    """Records that are alike but for their places.

    Attributes:
        trial: One of them.
        number: How many there are.
        steps: The steps of all of them.
    """

    trial: Trial
    number: int
    steps: int


def count_records(store: Database, study: Study) -> list[Counted]:
    """The records of a study that count, of each trial the last one.

    Raises:
        BadFile: If one that is read is damaged or of another study.
    """
    own, reader, found = Own(store, study), TrialReader(), list[Counted]()
    select = (
        "select min(id), identity, count(*), sum(steps) from trial "
        "where current and fork is null and alike is {} group by {}"
    )
    groups = [
        *store.rows(select.format("not null", "alike, identity")),
        *store.rows(select.format("null", "id")),
    ]
    for number, identity, many, steps in sorted(groups):
        trial = trial_in(store, reader, *store.one("select key, record from trial where id = ?", number))
        own.check(trial.key, trial.spec, trial.condition, trial.repetition, trial.trial, identity)
        found.append(Counted(trial, many, steps))
    return found


def played_cells(study: Study, records: Iterable[Counted]) -> dict[str, list[Counted]]:
    """The records of each agent under each condition, by the first three parts of their keys, in the study's order."""
    found = grouped(records, lambda one: (one.trial.spec, one.trial.condition))
    order = [(agent, one.label) for agent in study.agents for one in study.conditions]
    return {found[cell][0].trial.name.cell: found[cell] for cell in order if cell in found}


@dataclass(frozen=True, slots=True, kw_only=True)
class Invalid:
    """A condition without a valid trial.

    Attributes:
        condition: Its name, for example ``flips/random/flip?p=0.4``.
        errors: Trials of it that ended as an error, 1 or more.
        first: The error of the first of them.
        owed: How many of them are owed again.
        final: The boundaries at which the others ended.
    """

    condition: str
    errors: int
    first: TrialError
    owed: int
    final: tuple[str, ...]


def invalid_conditions(study: Study, records: Iterable[Counted]) -> list[Invalid]:
    """The conditions of a study that have errors and no valid trial, in the order of the study.

    Conditions that nobody has played yet, and those of people, are left out.
    """
    found = []
    for cell, trials in played_cells(study, records).items():
        errors = [(one.trial, one.trial.error) for one in trials if one.trial.error is not None]
        if len(errors) == len(trials) and not errors[0][0].player:
            first = min(errors, key=lambda one: (one[0].repetition, one[0].trial))
            invalid = Invalid(
                condition=cell,
                errors=len(errors),
                first=first[1],
                owed=sum(trial.owed_again for trial, _ in errors),
                final=tuple(sorted({error.boundary for trial, error in errors if not trial.owed_again})),
            )
            found.append(invalid)
    return found


def idle_conditions(study: Study, records: Iterable[Counted]) -> list[str]:
    """The conditions in which nothing was changed although something should act, as ``flips/random/nudge``.

    In the order of the study.
    """
    acting = {one.label for one in study.conditions if not (one.does_nothing or one.plant.options)}
    return [
        cell
        for cell, found in played_cells(study, records).items()
        if found[0].trial.condition in acting
        for over in [ended([one.trial for one in found])]
        if len(named := {tuple(trial.changed) for trial in over}) == 1
        and named != {()}  # the trials say what was changed
        and not any(trial.changed_steps for trial in over)
    ]
