"""``lockprobe play``: a person plays one trial at a terminal with keys, then sees the truth."""

from __future__ import annotations

import asyncio
import os
import re
import secrets
import select
import sys
import termios
import tty
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Annotated, Any, Literal, Self

import numpy as np
import typer

from lockprobe.agents.outside import participant_spec
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.sketch import interlock_lines, panel_lines, reading_order
from lockprobe.boxes.solve import optimum, random_curve
from lockprobe.cli import options
from lockprobe.cli.printing import Screen
from lockprobe.cli.study_options import with_study_options
from lockprobe.foundation.errors import BadFile, BadValue, LockprobeError
from lockprobe.foundation.formatting import count
from lockprobe.foundation.inputs import check_regular
from lockprobe.foundation.storage.atomic_file import writing
from lockprobe.foundation.storage.links import refuse_links
from lockprobe.studies.options.studyfile import trial_study
from lockprobe.studies.running.single import run_trial
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.record import Decision, Fact, Outcome, Percept, Situation, Task, Trial
from lockprobe.trial.told_outcome import in_words
from lockprobe.trial.trial_json import trial_to_json

ViewKind = Literal["text", "panel"]
"""How reports are shown: in words as models read them, or as a drawing."""

OTHERS = ("ideal-observer", "human-inspired", "random")
"""The strategies that play the same trial afterwards."""

_SEEDS = 10_000
"""The number of seeds from which a seed is drawn if none is given."""


@with_study_options(only=("box", "p", "seed", "max_steps", "flip", "layout", "shuffle", "assessment"))
def play(
    asked: Mapping[str, Any],
    view: Annotated[ViewKind, typer.Option(help=options.VIEW)] = "panel",
    record: Annotated[
        Path | None, typer.Option(metavar="FILE.jsonl", help="Append the trial to this file, as studies record it.")
    ] = None,
) -> None:
    """Play a trial yourself, with keys: the same box, reports and budget as any agent; then see the truth.

    Without --p, all reports are true. Without --seed, it is drawn. A letter is an answer; --assessment also asks what
    your last action did, as it asks agents.
    """
    asked = {"assessment": False, **asked}
    seed = asked.get("seed", secrets.randbelow(_SEEDS))
    if record is not None:
        _check_record(record)
    rates = asked.get("p", [0.0])
    if len(rates) != 1:
        raise BadValue("p", ",".join(f"{rate:g}" for rate in rates), "one number from 0 to 1")
    options_given = {**asked, "seed": seed, "p": rates[0]}
    study = trial_study(options_given, agent=participant_spec("local"))
    plan = study.plan(study.agents[0], study.conditions[0], 1, 1)
    screen = Screen()
    screen.say(f"Lockbox (--seed {seed} plays this trial again)", "bold")
    try:
        trial = _played(plan, view, screen)
    except Ended as ended:
        screen.say(str(ended))
        screen.say(f"To go on, play again with --seed {seed} and one letter more than before.")
        raise typer.Exit(1) from None
    except Left:
        screen.say("Stopped; nothing is saved.")
        return
    except KeyboardInterrupt:
        screen.say()
        raise
    if record is not None:
        _append(record, trial)
    others = {spec: _of(spec, options_given) for spec in OTHERS}
    tell(screen, trial, plan.box, others)
    if record is not None:
        screen.say(f"Recorded: {record}")


def _played(plan: Plan, view: ViewKind, screen: Screen) -> Trial:
    """Play the trial without asyncio.run, which would delay Ctrl-C during the wait for a key."""
    loop = asyncio.new_event_loop()
    try:
        with Keys() as keys:
            person = Person(plan.box, Names(plan).labels, view, keys, screen)
            return loop.run_until_complete(play_timed(plan, person))[0]
    finally:
        loop.close()


def _of(spec: str, asked: Mapping[str, Any]) -> Trial | None:
    """The same trial played by a strategy; None if the box is too large for it."""
    try:
        return run_trial(**{**asked, "agent": spec})
    except BadValue:
        return None


def _check_record(path: Path) -> None:
    """Refuse a file that cannot be appended to, before the trial; create no file."""
    if not path.absolute().parent.is_dir():
        raise BadFile(path, "its directory does not exist")
    refuse_links(path)
    check_regular(path)
    there = path.exists()
    with writing(path):
        path.open("ab").close()
    if not there:
        path.unlink()


def _append(path: Path, trial: Trial) -> None:
    with writing(path), path.open("ab+") as file:
        if path.stat().st_nlink > 1:
            raise BadFile(
                path, "has a second name elsewhere (a hard link), which would be written too: put a copy here"
            )
        file.seek(-1 if file.tell() else 0, os.SEEK_END)
        before = b"" if file.read() in (b"", b"\n") else b"\n"  # a last line without its end is ended
        file.write(before + trial_to_json(trial) + b"\n")


def relabelled(box: Lockbox, labels: tuple[str, ...]) -> Lockbox:
    """The same box with its joints named by the labels that the player knew, in panel order."""
    names = dict(zip(box.names, labels, strict=True))
    return replace(
        box,
        joints=tuple(replace(joint, name=names[joint.name]) for joint in box.joints),
        interlock={
            names[joint]: tuple({names[other]: position for other, position in clause.items()} for clause in clauses)
            for joint, clauses in box.interlock.items()
        },
        target=names[box.target],
    )


def tell(screen: Screen, trial: Trial, box: Lockbox, others: dict[str, Trial | None]) -> None:
    """Print the hidden truth of a trial: real outcomes, interlock, and the results of others.

    ``others`` are the results of strategies in the same trial, by spec; None if one cannot play this box.
    """
    steps = len(trial.steps)
    screen.say()
    if trial.solved:
        screen.say(f"You opened the box in {count(steps, 'step')}.", "bold green")
    else:
        screen.say(f"The box is not open after {count(steps, 'step')}.", "bold yellow")
    screen.say()
    _story(screen, trial)
    screen.say()
    screen.say("The interlock", "bold")
    for line in interlock_lines(relabelled(box, trial.labels)):
        screen.say("  " + line)
    screen.say()
    screen.say(f"The same trial played by strategies: same labels, same false reports (seed {trial.seed})", "bold")
    fewest = optimum(box)
    standing = {
        "you": _ending(trial),
        **{one: "cannot plan for a box of this size" if of is None else _ending(of) for one, of in others.items()},
        "fewest possible": "cannot be opened" if fewest is None else count(fewest, "step"),
    }
    for who, how in standing.items():
        screen.say(f"  {who:24} {how}")
    curve = random_curve(box, trial.budget)
    within = f"{curve[steps]:.1%} of trials within {count(steps, 'step')}, " if steps < trial.budget else ""
    screen.say(f"  Blind choices open the box in {within}{curve[-1]:.1%} within {trial.budget}.")


def _story(screen: Screen, trial: Trial) -> None:
    asked = trial.assessment and len(trial.steps) > 1
    screen.say(f"step  joint  {'truth':14}{'told':23}{'you then said' if asked else ''}".rstrip(), "bold")
    label = dict(zip(trial.joints, trial.labels, strict=True))
    for step, claimed in zip(trial.steps, trial.said, strict=True):
        false = step.told_falsely
        told = f"{in_words(step.told_moved):12} {'<- false' * false}"
        line = f"{step.step:4}  {label[step.joint]:5}  {in_words(step.moved):14}{told:23}{in_words(claimed, '')}"
        screen.say(line.rstrip(), "red" if false else "")
    lies = sum(step.told_falsely for step in trial.steps)
    screen.say(f"{lies} of {len(trial.steps)} reports were false (flip rate {trial.p:g}).")
    if asked:
        pairs = list(zip(trial.steps, trial.said, strict=True))[:-1]
        right = sum((claimed == "moved") == step.moved for step, claimed in pairs)
        screen.say(f"Your statements about your actions were true {right} of {len(pairs)} times.")


def _ending(trial: Trial) -> str:
    return count(len(trial.steps), "step") if trial.solved else f"not within {count(trial.budget, 'step')}"


_RULES = """\
The box has {count} joints, each in one of two positions. They lock each other in a
hidden way: whether a joint can move depends on the positions of other joints.
In every step you choose one joint. If it is not locked it moves to its other
position; if it is locked, nothing happens. The box is open as soon as the
target joint, {target}, moves. You have {budget} steps."""

_OUTCOMES, _POSITIONS = "whether it moved", "which joints are at position 1"

_CLAIMS: dict[str, Outcome] = {"M": "moved", "N": "blocked"}


class Left(LockprobeError):
    """Raised when the person stops during a trial."""


class Ended(Left):
    """Raised when the input ends during a trial."""


class Person:
    """The person at the terminal as an agent. It sees the panel of ``box``, not its interlock.

    ``labels`` are in panel order.
    """

    def __init__(self, box: Lockbox, labels: Sequence[str], view: ViewKind, keys: Keys, screen: Screen) -> None:
        self._box, self._labels, self._view = box, tuple(labels), view
        self._keys, self._screen = keys, screen

    @property
    def facts(self) -> Mapping[str, Fact]:
        """The facts of how the trial was played."""
        return {"view": self._view, "page": "terminal"}

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """The person's choice.

        Raises:
            Left: If the person stops; as ``Ended`` if the input ends.
        """
        task, percept, step = situation.task, situation.percept, len(situation.past) + 1
        if step == 1:
            self._rules(task, percept)
        self._screen.say()
        self._screen.say(f"Step {step} of {task.budget}", "bold")
        self._show(situation)
        claimed: Outcome | None = None
        if task.assessment and percept.joint is not None:
            claimed = _CLAIMS[
                self._ask("What did your last action do? m it moved, n it did not move: ", "MN", situation)
            ]
        order = task.joints if self._view == "text" else [self._labels[i] for i in reading_order(self._box)]
        joints = " ".join(label + "*" * (label == task.target) for label in order)
        return Decision(joint=self._ask(f"Which joint? {joints}: ", order, situation), claimed=claimed)

    def _rules(self, task: Task, percept: Percept) -> None:
        for line in _RULES.format(count=len(task.joints), target=task.target, budget=task.budget).splitlines():
            self._screen.say(line)
        legend = panel_lines(self._box, positions=[None] * len(self._labels))[-1]
        told = [_OUTCOMES] * (not percept.states_only) + [_POSITIONS] * (percept.positions is not None)
        text = f"After every step you are told {', and '.join(told)}."
        self._screen.say(f"The panel: {legend}." if self._view == "panel" else text)
        self._screen.say("Keys: the letter of a joint; ? for help; q to stop.", "dim")

    def _show(self, situation: Situation) -> None:
        task, percept = situation.task, situation.percept
        if self._view == "text":
            self._screen.say(percept.text)
            return
        if percept.joint is not None:
            outcome = percept.outcome
            told = f"{percept.joint} {in_words(outcome)}." if outcome else f"You attempted {percept.joint}."
            self._screen.say(told)
            if outcome is None:
                self._screen.say(_changed(situation))
        at = dict(zip(task.joints, percept.positions or [None] * len(task.joints), strict=True))
        positions = [at[label] for label in self._labels]
        for line in panel_lines(self._box, labels=self._labels, positions=positions)[:-1]:
            self._screen.say(line)

    def _ask(self, question: str, choices: Sequence[str], situation: Situation) -> str:
        while True:
            self._screen.say(question, end="")
            key = self._keys.next()
            self._screen.say(key.strip() if key is not None else "")
            if key is None:
                raise Ended(f"No letter came for step {len(situation.past) + 1}, and nothing is saved.")
            if key == "Q":
                raise Left("stopped")
            if key == "?":
                self._rules(situation.task, situation.percept)
            elif key in choices:
                return key
            else:
                self._screen.say(f"Unknown key; press {', '.join(choices)}, ? for help, q to stop.", "yellow")


def _changed(situation: Situation) -> str:
    """The joints whose told position differs from the one told before: what two panels show, and no outcome."""
    now, before = situation.percept.positions, situation.past[-1].percept.positions
    if now is None or before is None:
        return "No positions are told."
    changed = [label for label, *pair in zip(situation.task.joints, now, before, strict=True) if pair[0] != pair[1]]
    return f"Changed on the panel: {', '.join(sorted(changed)) or 'nothing'}."


_END = "\x04"
"""The character that a terminal sends for Ctrl-D."""

_SEQUENCE = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]?|O?.?)", re.DOTALL)
"""An escape sequence, as arrow keys send it; it is ignored."""

_PATIENCE = 0.02
"""Seconds to wait for the rest of an escape sequence."""

_HEED = 0.2
"""Seconds between checks for a Ctrl-C that came just before the wait for a key and did not interrupt it."""


class Keys:
    """Reads keys from standard input. On exit it restores the terminal's settings."""

    def __init__(self) -> None:
        self._terminal = sys.stdin.fileno() if sys.stdin is not None and sys.stdin.isatty() else None
        self._before: list[object] = []
        self._pressed: list[str] = []

    def __enter__(self) -> Self:
        if self._terminal is not None:
            self._before = termios.tcgetattr(self._terminal)
            tty.setcbreak(self._terminal)  # Ctrl-C stays what it is
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._terminal is not None:
            with suppress(termios.error):  # the terminal is gone
                termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._before)  # type: ignore[arg-type] # what was got

    def next(self) -> str | None:
        """The next key, or the first character of a line, as a capital. None at the end of input and for Ctrl-D."""
        if self._terminal is not None:
            return self._press(self._terminal)
        for line in sys.stdin or ():
            if line.strip():
                return line.strip()[0].upper()
        return None

    def _press(self, terminal: int) -> str | None:
        while not self._pressed:
            while not select.select([terminal], [], [], _HEED)[0]:
                pass
            read = os.read(terminal, 1024)
            if not read:
                return None
            while _SEQUENCE.search(read.decode("utf-8", "replace")) and select.select([terminal], [], [], _PATIENCE)[0]:
                read += os.read(terminal, 1024)
            plain = _SEQUENCE.sub("", read.decode("utf-8", "replace"))
            self._pressed = [key.upper() for key in plain if not key.isspace()]
        key = self._pressed.pop(0)
        return None if key == _END else key
