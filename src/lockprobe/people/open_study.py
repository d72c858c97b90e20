"""A study is opened for people: its directory, its settings, those who take part already; what was killed is mended."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from lockprobe.agents.participant import participant_spec
from lockprobe.errors import BadFile, BadValue, SettingsChanged
from lockprobe.inputs import read_input
from lockprobe.people.assignment import boxes_each
from lockprobe.people.diary import PEOPLE_DIRECTORY, Did, Entry
from lockprobe.people.diary_archive import kept_diaries
from lockprobe.people.directory import PeopleDirectory
from lockprobe.people.experiment import EXPERIMENT, SECRET, Experiment, kept_experiment
from lockprobe.people.journey import Journey, fingerprint
from lockprobe.people.paused_trial import Played
from lockprobe.people.practice import practice_plan
from lockprobe.people.responses import Attempt
from lockprobe.people.session import Seat, Table
from lockprobe.people.text_scenes import Texts
from lockprobe.people.texts import LANGUAGES, TEXTS, Words, read_words, words_file
from lockprobe.people.withdrawal import finish_withdrawal, put
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.record import Trial
from lockprobe.spec import PEOPLE
from lockprobe.storage.atomic_file import write_private
from lockprobe.studies.directory import write_settings
from lockprobe.studies.journal import Journal
from lockprobe.studies.play import own_thread
from lockprobe.studies.settings import read_study
from lockprobe.studies.study import Study
from lockprobe.trial import here

__all__ = ["opened", "seats_on_disk", "words_to_read"]

_MAY_CHANGE = {"participants", "away_hours", "language", "require_id", "joins_per_minute", *SECRET}
"""Settings that change nothing of what somebody is shown in a box; of the language the texts themselves count."""


def words_to_read(directory: Path, experiment: Experiment) -> Words:
    """What people read here. A language that ships may change with a release: once somebody has joined its copy holds.

    Raises:
        UnknownName: If there is no such language.
        BadFile: If something there is damaged, or the texts are none.
    """
    copy = directory / PEOPLE_DIRECTORY / TEXTS
    held = (
        experiment.language in LANGUAGES
        and copy.is_file()
        and any(kept.joined.token for kept in kept_diaries(directory))
    )
    return read_words(str(copy) if held else experiment.language)


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
    """A study that people can play, in its directory; closed afterwards. Where a start fails it is left as it was.

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
        own_thread() if study.simulated else nullcontext(here) as there,
    ):
        write_settings(directory, study)
        finish_withdrawal(journal)
        with PeopleDirectory(directory) as people:
            _settle(directory, experiment, words)
            yield Table(
                study=study,
                experiment=experiment,
                words=words,
                texts=Texts(words, study, experiment),
                practice=practice,
                journal=journal,
                people=people,
                place=there,
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


async def seats_on_disk(table: Table) -> list[Seat]:
    """Everybody who takes part already. Trials that were over and not written down are played again and written.

    Raises:
        BadFile: If a diary is damaged or copied, tells of other steps than the record, or a trial is not told again as
            it was shown.
    """
    seats, whose = [], dict[str, str]()
    for kept in kept_diaries(table.journal.directory):
        kept.check_slots(table.study, table.journal.directory)
        token, identity = kept.joined.token, kept.joined.identity
        if token and whose.setdefault(token, identity) != identity:
            raise BadFile(_diary(table, identity), f"a copy of the diary of {whose[token]}")
        diary = (kept.joined, *kept.lines)
        journey = Journey.of(diary, table.experiment, table.words)
        seat = Seat(table, journey)
        for box, ending in journey.endings.items():
            slot = journey.joined.slots[box - 1]
            agent = participant_spec(journey.identity)
            plan = table.study.plan(agent, table.study.condition(slot.p, slot.modality), slot.repetition, slot.trial)
            if ending == "error":
                continue
            played, began, ended = _steps(diary, box)
            if table.journal.owes(plan.key):
                await seat.record_again(box, played, began, ended)
            elif not _as_recorded(played, table.journal.trials[plan.key], agent):
                raise BadFile(_diary(table, identity), f"other steps than in the record of {plan.key}")
        seats.append(seat)
    return seats


def _as_recorded(played: Sequence[Played], trial: Trial, agent: str) -> bool:
    """Whether steps are those of a trial on record, if it is theirs and its steps are at hand."""
    theirs = trial.agent == agent and bool(trial.steps)
    return not theirs or [step.joint for step in played] == [step.decision.joint for step in trial.steps]


def _diary(table: Table, identity: str) -> Path:
    return table.journal.directory / PEOPLE_DIRECTORY / f"{identity}.jsonl"


def _steps(diary: Sequence[Entry], box: int) -> tuple[list[Played], float, float]:
    """The steps of one box, when it was first shown and when it was over, seconds since 1970."""
    played, began, at = [], 0.0, 0.0
    for before, line in pairwise(diary):
        if isinstance(line, Did) and isinstance(line.act, Attempt) and line.box == box:
            began, at = began or before.at, line.at
            played.append(Played(joint=line.act.joint, claimed=line.act.claimed, told=line.told))
    return played, began, at


def _settle(directory: Path, experiment: Experiment, words: Words) -> None:
    """Write the settings down, or hold them and the texts against those under which people have joined.

    Texts are the same wherever their file lies. Whoever came from elsewhere may have read others: they do not go on
    here.
    """
    path = directory / PEOPLE_DIRECTORY / EXPERIMENT
    asked, known = experiment.model_dump(mode="json"), kept_experiment(directory)
    diaries = kept_diaries(directory)
    read = {kept.joined.words for kept in diaries if kept.joined.token}
    different: dict[str, tuple[object, object]] = {}
    if read - {fingerprint(words)}:
        different["texts"] = (", ".join(sorted(read)), fingerprint(words))
    if known is not None and diaries:
        there = known.model_dump(mode="json")
        changed = (name for name in asked if name not in _MAY_CHANGE and there[name] != asked[name])
        different |= {name: (there[name], asked[name]) for name in changed}
    if different:
        raise SettingsChanged(path.parent, different)
    put(path, asked)
    if not diaries and (texts := words_file(experiment.language)).is_file():
        write_private(directory / PEOPLE_DIRECTORY / TEXTS, read_input(texts))
