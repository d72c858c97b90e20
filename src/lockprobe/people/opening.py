"""A study is opened for people: its directory, its settings, those who take part already; what was killed is mended."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from lockprobe.agents.participant import participant_spec
from lockprobe.errors import BadFile, BadValue, SettingsChanged
from lockprobe.lockbox.families import box as named_box
from lockprobe.options import PEOPLE
from lockprobe.people.assignment import boxes_each
from lockprobe.people.diary import PEOPLE_DIRECTORY, Did, Entry, read_diaries
from lockprobe.people.experiment import EXPERIMENT, Experiment
from lockprobe.people.held import Played
from lockprobe.people.journey import Journey
from lockprobe.people.scenes import Attempt
from lockprobe.people.seat import Seat, Table
from lockprobe.people.taking import kept_experiment
from lockprobe.people.telling import Texts
from lockprobe.people.withdrawal import finish_withdrawal, put
from lockprobe.people.words import Words
from lockprobe.plan import Plan
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.seeds import integer_seed
from lockprobe.studies.journal import Journal, write_settings
from lockprobe.studies.settings import read_study
from lockprobe.studies.stage import own_thread
from lockprobe.studies.study import Study
from lockprobe.trial import here

__all__ = ["opened", "practice_plan", "seats_on_disk"]

_MAY_CHANGE = {"participants", "completion_url", "completion_code", "away_hours"}
"""Settings that change nothing of what somebody is shown in a box."""


@contextmanager
def opened(
    directory: Path,
    study: Study,
    experiment: Experiment,
    words: Words,
    *,
    clock: Callable[[], float],
    page: str,
) -> Iterator[Table]:
    """A study that people can play, in its directory; closed afterwards.

    Raises:
        SettingsChanged: If the directory holds another study, or people have joined under other settings.
        DirectoryBusy: If another process is writing there.
        BadFile: If something in it is damaged.
        UserMistake: If the plant cannot be had, or there is no such practice box.
    """
    known = read_study(directory).agents if (directory / "study.json").exists() else study.agents
    study = replace(study, agents=tuple(dict.fromkeys((*known, PEOPLE))))
    study.check_agents()
    _check(study, experiment)
    practice = practice_plan(study, experiment)
    plant = resolve_plant(study.plant)
    for box in (study.box, *([practice.box] if practice else [])):
        plant.check(box)
    with (
        Journal.open(directory, replace(study, agents=known)) as journal,
        own_thread() if study.simulated else nullcontext(here) as place,
    ):
        write_settings(directory, study)
        finish_withdrawal(journal)
        _settle(directory, experiment)
        yield Table(
            study=study,
            experiment=experiment,
            words=words,
            texts=Texts(words, study, experiment),
            practice=practice,
            journal=journal,
            place=place,
            clock=clock,
            page=page,
        )


def _check(study: Study, experiment: Experiment) -> None:
    """Refuse settings that do not fit the study."""
    luck, boxes = study.repetitions * study.trials, boxes_each(study, experiment)
    if (experiment.trials_each or 1) > luck:
        raise BadValue("trials_each", experiment.trials_each, f"at most {luck}, the trials of a condition")
    for check in experiment.checks:
        if check.after > boxes:
            raise BadValue("checks, after", check.after, f"at most {boxes}, the boxes of a participant")


def practice_plan(study: Study, experiment: Experiment) -> Plan | None:
    """The practice box as a trial: the same for everybody, and all that is told of it is true; None without.

    Raises:
        UnknownName: If there is no such box.
    """
    if not experiment.practice:
        return None
    modality = study.modalities_of(PEOPLE)[0]
    practice = replace(
        study,
        name="practice",
        agents=(PEOPLE,),
        box=named_box(experiment.practice),
        p=(0.0,),
        modalities=(modality,),
        repetitions=1,
        trials=1,
        seed=integer_seed(study.seed, "people", "practice"),
        layout="fixed",
    )
    return practice.plan(PEOPLE, 0.0, 1, 1, modality)


async def seats_on_disk(table: Table) -> list[Seat]:
    """Everybody who takes part already. Trials that were over and not written down are played again and written.

    Raises:
        BadFile: If a diary is damaged, or a trial is not told again as it was shown.
    """
    seats = []
    for diary in read_diaries(table.journal.directory):
        journey = Journey.of(diary, table.experiment, table.words)
        _check_slots(table, journey)
        seat = Seat(table, journey)
        for box, ending in journey.endings.items():
            slot = journey.joined.slots[box - 1]
            agent = participant_spec(journey.identity)
            plan = table.study.plan(agent, slot.p, slot.repetition, slot.trial, slot.modality)
            if ending != "error" and table.journal.owes(plan.key):
                await seat.record_again(box, *_steps(diary, box))
        seats.append(seat)
    return seats


def _check_slots(table: Table, journey: Journey) -> None:
    study = table.study
    for slot in journey.joined.slots:
        if (
            slot.p not in study.p
            or slot.modality not in study.modalities
            or not 1 <= slot.repetition <= study.repetitions
            or not 1 <= slot.trial <= study.trials
        ):
            path = table.journal.directory / PEOPLE_DIRECTORY / f"{journey.identity}.jsonl"
            raise BadFile(path, "line 1: trials of another study")


def _steps(diary: Sequence[Entry], box: int) -> tuple[list[Played], float, float]:
    """The steps of one box, when it was first shown and when it was over, seconds since 1970."""
    played, began, at = [], 0.0, 0.0
    for before, line in pairwise(diary):
        if isinstance(line, Did) and isinstance(line.act, Attempt) and line.box == box:
            began, at = began or before.at, line.at
            played.append(Played(joint=line.act.joint, claimed=line.act.claimed, told=line.told))
    return played, began, at


def _settle(directory: Path, experiment: Experiment) -> None:
    """Write the settings down, or hold them against those under which people have joined."""
    path = directory / PEOPLE_DIRECTORY / EXPERIMENT
    asked, known = experiment.model_dump(mode="json"), kept_experiment(directory)
    if known is not None and any(read_diaries(directory)):
        there = known.model_dump(mode="json")
        different = {
            name: (there[name], asked[name]) for name in asked if name not in _MAY_CHANGE and there[name] != asked[name]
        }
        if different:
            raise SettingsChanged(path.parent, different)
    put(path, asked)
