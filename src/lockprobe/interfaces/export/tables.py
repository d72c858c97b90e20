"""The tables of a study: steps, trials, calls of models, and what only people have."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.terminal_text import readable
from lockprobe.interfaces.export.data_dictionary import PLATFORM
from lockprobe.interfaces.export.table_files import Rows, rows_of
from lockprobe.interfaces.export.tidy import COLUMNS, TidyCell, tidy_columns, tidy_rows, trial_columns, trial_rows
from lockprobe.people.diary import (
    Answer,
    Answers,
    Attempt,
    Broken,
    Diary,
    Did,
    Released,
    read_diaries,
)
from lockprobe.people.experiment import Experiment, kept_experiment
from lockprobe.people.journey import Journey, acts_of_steps, seconds_of_trials
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial

TableName = Literal["steps", "trials", "calls", "participants", "acts", "checks", "answers"]

TABLES: Mapping[TableName, str] = {
    "steps": "a step of a finished trial: truth and report",
    "trials": "a finished trial: whether the box was opened, in how many steps, with which claims and loops",
    "calls": "a call to a model, with its tokens and seconds",
    "participants": "a participant: conditions, how far they came, checks, device",
    "acts": "an act of a participant, including practice and unfinished trials",
    "checks": "an answer to an attention check",
    "answers": "an answer to a question",
}
"""The tables by name, with the meaning of a row."""


@dataclass(frozen=True, slots=True)
class PeopleRecords:
    """The records of a study in which people took part.

    Attributes:
        directory: The directory of the study.
        study: The study.
        trials: Its trials, in the order in which they were finished.
        diaries: The diaries of its participants, in the order in which they joined, without their tokens and the time
            of day.
        experiment: The settings for people; None if they are not stored.
    """

    directory: Path
    study: Study
    trials: tuple[Trial, ...]
    diaries: tuple[Diary, ...]
    experiment: Experiment | None = None

    @classmethod
    def read(cls, directory: Path, *, platform_ids: bool = False) -> PeopleRecords:
        """The records in the directory of a study.

        ``platform_ids`` keeps what the recruitment platform said of participants.

        Raises:
            BadFile: If the directory is not a study's, or a file in it is damaged.
        """
        return cls(
            directory,
            read_study(directory),
            tuple(load(directory)),
            tuple(kept.without_identity(platform=platform_ids) for kept in read_diaries(directory)),
            kept_experiment(directory),
        )


def table_of(directory: Path, name: TableName, *, platform_ids: bool = False) -> Rows:
    """A table of the study in a directory.

    Raises:
        BadFile: If a file is damaged, a diary and a record disagree, or the table is of people and nobody took part.
    """
    if name == "calls":
        return Rows(_about(name), _CALL, _calls(directory))
    records = PeopleRecords.read(directory, platform_ids=platform_ids)
    if records.diaries:
        return people_table(records, name)
    if name in ("steps", "trials"):
        return rows_of(name, records.trials)
    raise BadFile(directory, f"nobody took part in this study, so it has no table of {name}")


def people_table(records: PeopleRecords, name: TableName) -> Rows:
    """A table of a study with people. Unfinished trials are in the acts, not in the steps.

    Raises:
        BadFile: If a diary and a record disagree.
    """
    acts = acts_of_steps(
        records.study, {trial.key: trial for trial in records.trials}, records.diaries, records.directory
    )
    platform = sorted({name for kept in records.diaries for name in kept.joined.platform})
    seconds = seconds_of_trials(records.study, records.diaries)
    made: Mapping[str, tuple[tuple[str, ...], Callable[[], Iterable[Mapping[str, TidyCell]]]]] = {
        "steps": (_step_columns(records), lambda: _steps(records, acts)),
        "trials": (
            ("participant", *trial_columns(records.trials, seconds), "position", "view"),
            lambda: _trials(records, seconds),
        ),
        "participants": (
            (*_PARTICIPANT, *(f"{PLATFORM}{name}" for name in platform)),
            lambda: (_participant(kept, records.experiment) for kept in records.diaries),
        ),
        "acts": (_ACT, lambda: _acts(records, acts)),
        "checks": (_CHECK, lambda: _checks(records)),
        "answers": (_ANSWER, lambda: _answers(records)),
    }
    columns, rows = made[name]
    whole = ({one: row.get(one, "") for one in columns} for row in rows())
    return Rows(
        _about(name),
        columns,
        [{one: readable(cell) if isinstance(cell, str) else cell for one, cell in row.items()} for row in whole],
    )


def _about(name: TableName) -> str:
    return f"A row is {TABLES[name]}."


_CALL = ("key", "agent", "step", "call", "input_tokens", "output_tokens", "call_seconds")
_PARTICIPANT = (
    "participant",
    "language",
    "texts",
    "boxes_assigned",
    "boxes_finished",
    "boxes_broken",
    "left_in_box",
    "left_after_step",
    "released",
    "comprehension_rounds",
    "screened",
    "checks_right",
    "checks_wrong",
    "seconds",
    "box_seconds",
    "conditions",
    "finished",
    "questions_left",
    "pointers",
    "window_width",
    "window_height",
)
_ACT = (
    "participant",
    "turn",
    "scene",
    "position",
    "key",
    "step",
    "label",
    "claim",
    "report",
    "shown",
    "rt_ms",
    "claim_rt_ms",
    "at",
    "ended",
    "recorded",
    "pointer",
    "window_width",
    "window_height",
)
_CHECK = ("participant", "check", "question", "answer", "right", "rt_ms", "at")
_ANSWER = ("participant", "name", "question", "answer", "rt_ms", "at")


def _calls(directory: Path) -> Iterator[dict[str, TidyCell]]:
    for call in read_calls(directory):
        if not call.owed_anew:
            yield {
                "key": call.key,
                "agent": call.agent,
                "step": call.step,
                "call": call.turn,
                "input_tokens": call.usage.input_tokens,
                "output_tokens": call.usage.output_tokens,
                "call_seconds": call.seconds,
            }


def _step_columns(records: PeopleRecords) -> tuple[str, ...]:
    more = tidy_columns(records.trials)[len(COLUMNS) :]
    return ("participant", *COLUMNS, *more, "position", "view", "report", "shown", "rt_ms", "claimed_rt_ms", "at")


def _steps(records: PeopleRecords, acts: Mapping[tuple[str, int], Did]) -> Iterator[dict[str, TidyCell]]:
    rows = tidy_rows(records.trials)
    for trial in records.trials:
        for step in trial.steps:
            did, after = (acts.get((trial.key, number)) for number in (step.step, step.step + 1))
            yield {
                "participant": _identity(trial),
                **next(rows),
                "position": _fact(trial, "position"),
                "view": _fact(trial, "view"),
                "report": step.told,
                "claimed_rt_ms": _claim_time(after),
                **({} if did is None else {"shown": did.shown, **_times(did)}),
            }


def _trials(records: PeopleRecords, seconds: Mapping[str, float]) -> Iterator[dict[str, TidyCell]]:
    for trial, row in zip(records.trials, trial_rows(records.trials, seconds), strict=True):
        more = {"position": _fact(trial, "position"), "view": _fact(trial, "view")}
        yield {"participant": _identity(trial), **row, **more}


def _identity(trial: Trial) -> str:
    return trial.player.removeprefix(f"{trial.group}:")


def _fact(trial: Trial, name: str) -> TidyCell:
    value = trial.facts.get(name)
    return "" if value is None else value


def _times(did: Did) -> dict[str, TidyCell]:
    act = did.act
    times: dict[str, TidyCell] = {"at": did.at}
    if isinstance(act, Attempt | Answer | Answers):
        times["rt_ms"] = act.rt
    return times


def _claim_time(did: Did | None) -> TidyCell:
    """The response time of the claim of an act; empty without one."""
    said = did.act.claimed_rt if did is not None and isinstance(did.act, Attempt) else None
    return "" if said is None else said


def _participant(kept: Diary, experiment: Experiment | None) -> dict[str, TidyCell]:
    joined, boxes = kept.joined, range(1, len(kept.joined.slots) + 1)
    journey = Journey.of(kept)
    endings, checks = journey.endings, journey.checks
    language, _, texts = joined.words.partition(" ")
    row: dict[str, TidyCell] = {
        "participant": joined.identity,
        "language": language,
        "texts": texts,
        "boxes_assigned": len(boxes),
        "boxes_finished": sum(endings.get(box) in ("solved", "budget") for box in boxes),
        "boxes_broken": sum(endings.get(box) == "error" for box in boxes),
        "released": int(journey.shut == "late"),
        "comprehension_rounds": journey.rounds or "",
        "screened": int(journey.shut == "screened"),
        "checks_right": sum(checks),
        "checks_wrong": len(checks) - sum(checks),
        "seconds": round(max((act.at for act in kept.acts), default=joined.at) - joined.at, 3),
        "box_seconds": "; ".join(f"{journey.seconds(box):.1f}" if box in journey.steps else "" for box in boxes),
        "conditions": "; ".join(slot.condition for slot in joined.slots),
        "finished": int(journey.boxes_done and not journey.shut),
        "questions_left": "" if experiment is None else _open_questions(kept, experiment),
        **_device(kept),
        **{f"{PLATFORM}{name}": said for name, said in joined.platform.items()},
    }
    if left := next((box for box in boxes if box not in endings), None):
        steps = len(journey.steps.get(left, ()))
        row |= {"left_in_box": left if left > 1 or steps else 0, "left_after_step": steps}
    return row


def _open_questions(kept: Diary, experiment: Experiment) -> int:
    """How many attention checks and questions at the end a participant has not come to."""
    checks = enumerate(experiment.checks, 1)
    asked = {("check", str(number)) for number, check in checks if check.after <= len(kept.joined.slots)}
    asked |= {("ask", question.name) for question in experiment.questions}
    return len(asked - {(did.scene, did.item) for did in kept.acts if isinstance(did.act, Answer)})


def _device(kept: Diary) -> dict[str, TidyCell]:
    """The pointing devices of the choices, and the first window size; empty if the study does not store them."""
    attempts = [did.act for did in kept.acts if isinstance(did.act, Attempt)]
    used = Counter(act.pointer for act in attempts if act.pointer)
    width, height = next((act.viewport for act in attempts if act.viewport), ("", ""))
    pointers = " ".join(name for name, _ in used.most_common())
    return {"pointers": pointers, "window_width": width, "window_height": height}


def _acts(records: PeopleRecords, acts: Mapping[tuple[str, int], Did]) -> Iterator[dict[str, TidyCell]]:
    recorded = set(map(id, acts.values()))
    for kept in records.diaries:
        keys = {box: kept.key(records.study, box) for box in range(len(kept.joined.slots) + 1)}
        for line in kept.lines:
            if isinstance(line, Released):
                continue
            row: dict[str, TidyCell] = {"participant": kept.joined.identity, "turn": line.turn, "at": line.at}
            if line.box is not None:
                row |= {"position": line.box, "key": keys.get(line.box, "")}
            if isinstance(line, Broken):
                yield row | {"scene": "broken"}
                continue
            row |= {"scene": line.scene, **_times(line)}
            if isinstance(line.act, Attempt):
                row |= {"label": line.act.joint, "claim": line.act.claimed or "", "step": line.step or ""}
                row |= {"claim_rt_ms": _claim_time(line)}
                width, height = line.act.viewport or ("", "")
                row |= {"pointer": line.act.pointer or "", "window_width": width, "window_height": height}
                row |= {
                    "report": line.told,
                    "shown": line.shown,
                    "ended": line.ended or "",
                    "recorded": int(id(line) in recorded),
                }
            yield row


def _checks(records: PeopleRecords) -> Iterator[dict[str, TidyCell]]:
    asked = [check.question for check in records.experiment.checks] if records.experiment else []
    for kept in records.diaries:
        for did in kept.acts:
            if did.scene == "check" and isinstance(did.act, Answer):
                number = int(did.item) if did.item.isascii() and did.item.isdigit() else 0
                yield {
                    "participant": kept.joined.identity,
                    "check": number or "",
                    "question": asked[number - 1] if 0 < number <= len(asked) else "",
                    "answer": did.act.answer,
                    "right": "" if did.right is None else int(did.right),
                    **_times(did),
                }


def _answers(records: PeopleRecords) -> Iterator[dict[str, TidyCell]]:
    asked = (
        {question.name: question.question for question in records.experiment.questions} if records.experiment else {}
    )
    for kept in records.diaries:
        for did in kept.acts:
            if did.scene == "ask" and isinstance(did.act, Answer):
                yield {
                    "participant": kept.joined.identity,
                    "name": did.item,
                    "question": asked.get(did.item, ""),
                    "answer": did.act.answer,
                    **_times(did),
                }
