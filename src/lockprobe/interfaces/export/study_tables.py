"""The tables of the study in a directory: steps, trials, calls of models, and what only people have."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Literal, NamedTuple, get_args

from lockprobe.foundation.errors import BadFile
from lockprobe.interfaces.export.table import Column, Table, count, mark, number, text
from lockprobe.interfaces.export.trials import PAGE, PARTICIPANT, SERVER, steps_table, trials_table
from lockprobe.people.diary import Answers, Attempt, Diary, Did, acts_of_steps, read_diaries, seconds_of_trials
from lockprobe.people.experiment import Experiment, kept_experiment
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.study import Study

TableName = Literal["steps", "trials", "calls", "participants", "acts", "answers"]
TABLES: tuple[TableName, ...] = get_args(TableName)

_CALLS = (
    text("key", "The trial: its readable name in the study.", lambda call: call.key),
    text("agent", "The agent, by its name or spec.", lambda call: call.agent),
    count("step", "Step within the trial, from 1.", lambda call: call.step),
    count("call", "Number of the call for that step, from 1; later ones follow a malformed reply.",
          lambda call: call.turn),
    count("input_tokens", "Tokens that the model read, by its provider's count.", lambda call: call.usage.input_tokens,
          least=0),
    count("output_tokens", "Tokens that the model wrote, those of reasoning included.",
          lambda call: call.usage.output_tokens, least=0),
    number("call_seconds", "Time of the call, retries included.", lambda call: call.seconds, "s"),
)  # fmt: skip


class _Person(NamedTuple):
    """A participant: the diary, and how far they came."""

    kept: Diary

    @property
    def boxes(self) -> range:
        """The numbers of the boxes assigned."""
        return range(1, len(self.kept.joined.slots) + 1)

    @property
    def left_in(self) -> int | None:
        """The first unfinished box; None if all are finished."""
        return next((box for box in self.boxes if box not in self.kept.endings), None)

    def left_after(self, box: int) -> int:
        """Steps taken in a box."""
        return len(self.kept.steps.get(box, ()))


def _left_in_box(one: _Person) -> int | None:
    box = one.left_in
    return 0 if box == 1 and not one.left_after(1) else box


_PARTICIPANTS = (
    text("participant", PARTICIPANT, lambda one: one.kept.joined.identity),
    text("language", "Language of the texts on the page (BCP 47).",
         lambda one: one.kept.joined.words.partition(" ")[0]),
    text("texts", "Fingerprint of these texts; equal fingerprints mean equal texts.",
         lambda one: one.kept.joined.words.partition(" ")[2]),
    count("boxes_assigned", "Boxes assigned to the participant.", lambda one: len(one.boxes), least=0),
    count("boxes_finished", "Number of them that were finished: opened, or all steps taken.",
          lambda one: sum(one.kept.endings.get(box) in ("solved", "budget") for box in one.boxes), least=0),
    count("boxes_broken", "Number of them that broke through no fault of the participant.",
          lambda one: sum(one.kept.endings.get(box) == "error" for box in one.boxes), least=0),
    count("left_in_box", "The first unfinished box, at which the participant left; 0 without a step in any box: at the "
          "instructions, or in the practice. Empty if all are finished.", _left_in_box, least=0),
    count("left_after_step", "Steps taken in that box. Empty if all are finished.",
          lambda one: None if one.left_in is None else one.left_after(one.left_in), least=0),
    mark("released", "whether the participant was away so long that the remaining boxes were given to others.",
         lambda one: one.kept.late),
    count("comprehension_rounds", "Rounds in which the questions on the instructions were answered; 1 is right at "
          "first. Empty if none was.", lambda one: len(one.kept.rounds) or None),
    count("checks_right", "Attention checks answered correctly.", lambda one: sum(one.kept.checks), least=0),
    count("checks_wrong", "Attention checks answered incorrectly.",
          lambda one: len(one.kept.checks) - sum(one.kept.checks), least=0),
    number("seconds", f"Time from consent to the participant's last act, {SERVER}.", lambda one: _seconds(one.kept),
           "s"),
    text("conditions", "The conditions of the participant's boxes in order (truth; flip?p=0.4), separated by "
         "semicolons.", lambda one: "; ".join(slot.condition for slot in one.kept.joined.slots)),
    mark("finished", "whether all boxes of the participant are over, whether or not the questions after them are.",
         lambda one: one.kept.boxes_done and not one.kept.late),
)  # fmt: skip


def _seconds(kept: Diary) -> float:
    last = max((did.at for did in kept.lines if did.act is not None), default=kept.joined.at)
    return round(last - kept.joined.at, 3)


def _of_platform(name: str) -> Column:
    about = f"{name}, as the recruitment platform gave it in the URL."
    return text(f"platform_{name}", about, lambda one: one.kept.joined.platform.get(name))


class _ActRow(NamedTuple):
    """An act, or that a box broke; with the attempt that it was, and whether it is recorded."""

    participant: str
    did: Did
    key: str
    attempt: Attempt | None
    recorded: bool


_RT = f"Response time, from painting the scene to the joint, the answer or going on, without a claim, {PAGE}."
_AT = f"Time of arrival at the server, counted from the participant's consent, {SERVER}."

_ACTS = (
    text("participant", PARTICIPANT, lambda row: row.participant),
    count("turn", "Number of the answered scene, one act each; consent is the first.", lambda row: row.did.turn),
    text("scene", "Kind of the answered scene: page, box, over, check or ask; broken if a box could not be continued.",
         lambda row: row.did.scene if row.did.act else "broken"),
    count("position", "Number of the box in the participant's order, from 1; 0 for practice.",
          lambda row: row.did.box, least=0),
    text("key", "The trial: its readable name in the study.", lambda row: row.key),
    count("step", "Step within the trial, from 1.", lambda row: row.attempt and row.did.step),
    text("label", "The attempted joint, by its letter on the page.", lambda row: row.attempt and row.attempt.joint),
    text("claim", "What the participant said, with this act, of the step before: moved or blocked. Empty if it was not "
         "asked.", lambda row: row.attempt and row.attempt.claimed),
    text("report", "The report after the step, word for word. Empty with pictures.",
         lambda row: row.attempt and row.did.told),
    text("shown", "What the participant read of the step, in their language. Empty if the step ended the box.",
         lambda row: row.attempt and row.did.shown),
    number("rt_ms", _RT, lambda row: getattr(row.did.act, "rt", None), "ms"),
    number("claim_rt_ms", f"Response time, from painting the scene to the claim, {PAGE}. Empty if it was not asked.",
           lambda row: row.attempt and row.attempt.claimed_rt, "ms"),
    number("at", _AT, lambda row: row.did.at, "s"),
    text("ended", "How the trial or practice ended with this step: solved, budget or error. Empty if it continues.",
         lambda row: row.attempt and row.did.ended),
    mark("recorded", "whether the step belongs to a finished trial, which is in the table of steps.",
         lambda row: row.attempt and row.recorded),
    text("pointer", "Device of the choice: mouse, touch, pen or keyboard. Empty if the study does not store it.",
         lambda row: row.attempt and row.attempt.pointer),
    count("window_width", "Width of the browser's window at this choice. Empty if the study does not store it.",
          lambda row: row.attempt and row.attempt.viewport and row.attempt.viewport[0], least=0, unit="px"),
    count("window_height", "Height of the browser's window, as for window_width.",
          lambda row: row.attempt and row.attempt.viewport and row.attempt.viewport[1], least=0, unit="px"),
)  # fmt: skip


class _AnswerRow(NamedTuple):
    """An answer to an attention check or a question, with the question."""

    participant: str
    did: Did
    question: str


_ANSWERS = (
    text("participant", PARTICIPANT, lambda row: row.participant),
    text("scene", "check for an attention check, ask for a question at the end.", lambda row: row.did.scene),
    text("name", "The experimenter's name for the question; of an attention check its number, from 1.",
         lambda row: row.did.item),
    text("question", "The question. Empty if the settings of the experiment are not stored.", lambda row: row.question),
    text("answer", "The answer, word for word.", lambda row: row.did.act.answers[0]),
    mark("right", "whether the answer to an attention check is right.", lambda row: row.did.right),
    number("rt_ms", _RT, lambda row: row.did.act.rt, "ms"),
    number("at", _AT, lambda row: row.did.at, "s"),
)  # fmt: skip


def table_of(directory: Path, name: TableName, *, platform_ids: bool = False) -> Table:
    """A table of the study in a directory. Unfinished trials of people are in the acts, not in the steps.

    ``platform_ids`` keeps what the recruitment platform said of participants.

    Raises:
        BadFile: If a file is damaged, a diary and a record disagree, or the table is of people and nobody took part.
    """
    if name == "calls":
        calls = [call for call in read_calls(directory) if not call.owed_anew]
        return Table("a call to a model, with its tokens and seconds", _CALLS, lambda: calls)
    study, trials = read_study(directory), load(directory)
    diaries = [kept.without_identity(platform=platform_ids) for kept in read_diaries(directory)]
    acts = acts_of_steps(study, {trial.key: trial for trial in trials}, diaries, directory)
    if name == "steps":
        return steps_table(trials, acts)
    if name == "trials":
        return trials_table(trials, seconds_of_trials(study, diaries))
    if not diaries:
        raise BadFile(directory, f"nobody took part in this study, so it has no table of {name}")
    if name == "participants":
        people = [_Person(kept) for kept in diaries]
        platform = map(_of_platform, sorted({name for kept in diaries for name in kept.joined.platform}))
        about = "a participant: conditions, how far they came, checks"
        return Table(about, (*_PARTICIPANTS, *platform), lambda: people)
    if name == "acts":
        about = "an act of a participant, including practice and unfinished trials"
        return Table(about, _ACTS, lambda: _acts(study, diaries, acts))
    questions = _questions(kept_experiment(directory))
    answers = [
        _AnswerRow(kept.joined.identity, did, questions.get((did.scene, did.item), ""))
        for kept in diaries
        for did in kept.lines
        if isinstance(did.act, Answers) and did.scene in ("check", "ask")
    ]
    return Table("an answer to an attention check or a question", _ANSWERS, lambda: answers)


def _acts(study: Study, diaries: list[Diary], acts: Mapping[tuple[str, int], Did]) -> Iterator[_ActRow]:
    recorded = set(map(id, acts.values()))
    for kept in diaries:
        keys = {box: kept.key(study, box) for box in range(len(kept.joined.slots) + 1)}
        for did in kept.lines:
            if did.scene != "late":
                attempt = did.act if isinstance(did.act, Attempt) else None
                yield _ActRow(kept.joined.identity, did, keys.get(did.box or 0, ""), attempt, id(did) in recorded)


def _questions(experiment: Experiment | None) -> dict[tuple[str, str], str]:
    """Scene and name of what was asked -> the question; nothing if the settings of the experiment are not stored."""
    if experiment is None:
        return {}
    checks = {("check", str(number)): check.question for number, check in enumerate(experiment.checks, 1)}
    return checks | {("ask", question.name): question.question for question in experiment.questions}
