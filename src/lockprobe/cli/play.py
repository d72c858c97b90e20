"""``lockprobe play``: a person plays one trial at a terminal with keys, then sees the truth."""

from __future__ import annotations

import asyncio
import secrets
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import typer

from lockprobe.agents.outside import participant_spec
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.sketch import interlock_lines, panel_lines, reading_order
from lockprobe.boxes.solve import optimum, random_curve
from lockprobe.cli.printing import Screen
from lockprobe.cli.study_options import with_study_options
from lockprobe.foundation.errors import BadValue, LockprobeError
from lockprobe.foundation.formatting import count
from lockprobe.studies.options.studyfile import trial_study
from lockprobe.studies.running.single import run_trial
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.record import Decision, Fact, Outcome, Situation, Trial, in_words

OTHERS = ("ideal-observer", "human-inspired", "random")
"""The strategies that play the same trial afterwards."""

_SEEDS = 10_000
"""The number of seeds from which a seed is drawn if none is given."""

_RULES = """\
The box has {count} joints, each in one of two positions. They lock each other in a
hidden way: whether a joint can move depends on the positions of other joints.
In every step you choose one joint. If it is not locked it moves to its other
position; if it is locked, nothing happens. The box is open as soon as the
target joint, {target}, moves. You have {budget} steps."""

_CLAIMS: Mapping[str, Outcome] = {"M": "moved", "N": "blocked"}


class Left(LockprobeError):
    """Raised when the person stops during a trial, or the input ends."""


@with_study_options(only=("box", "p", "seed", "max_steps", "flip", "layout", "shuffle", "assessment"))
def play(asked: Mapping[str, Any]) -> None:
    """Play a trial yourself, with keys: the same box, reports and budget as any agent; then see the truth.

    Without --p, all reports are true. Without --seed, it is drawn. A letter is an answer; --assessment also asks what
    your last action did, as it asks agents. Nothing is saved.
    """
    rates, seed = asked.get("p", [0.0]), asked.get("seed", secrets.randbelow(_SEEDS))
    if len(rates) != 1:
        raise BadValue("p", ",".join(f"{rate:g}" for rate in rates), "one number from 0 to 1")
    options = {"assessment": False, **asked, "seed": seed, "p": rates[0]}
    study = trial_study(participant_spec("local"), **options)
    plan = study.plan(study.agents[0], study.conditions[0], 1, 1)
    screen = Screen()
    screen.say(f"Lockbox (--seed {seed} plays this trial again)", "bold")
    person = Person(plan.box, plan.names.labels, screen)
    loop = asyncio.new_event_loop()  # asyncio.run would delay Ctrl-C during the wait for a key
    try:
        trial, _ = loop.run_until_complete(play_timed(plan, person))
    except Left as left:
        screen.say(str(left))
        if left.args[0] != _STOPPED:
            screen.say(f"To go on, play again with --seed {seed} and one letter more than before.")
            raise typer.Exit(1) from None
        return
    finally:
        loop.close()
    others: dict[str, Trial | None] = {}
    for spec in OTHERS:
        try:
            others[spec] = run_trial(**{**options, "agent": spec})
        except BadValue:  # the box is too large for it
            others[spec] = None
    tell(screen, trial, plan.box, others)


_STOPPED = "Stopped; nothing is saved."


class Person:
    """The person at the terminal as an agent. It sees the panel of ``box``, not its interlock.

    ``labels`` are in panel order.
    """

    facts: ClassVar[Mapping[str, Fact]] = {}

    def __init__(self, box: Lockbox, labels: Sequence[str], screen: Screen) -> None:
        self._box, self._labels, self._screen = box, tuple(labels), screen

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """The person's choice.

        Raises:
            Left: If the person stops, or the input ends.
        """
        task, percept, step = situation.task, situation.percept, len(situation.past) + 1
        if step == 1:
            self._rules(situation)
        self._screen.say()
        self._screen.say(f"Step {step} of {task.budget}", "bold")
        if percept.joint is not None:
            outcome = percept.outcome
            self._screen.say(f"{percept.joint} {in_words(outcome)}." if outcome else f"You attempted {percept.joint}.")
            if outcome is None:
                self._screen.say(_changed(situation))
        at = dict(zip(task.joints, percept.positions or [None] * len(task.joints), strict=True))
        positions = [at[label] for label in self._labels]
        for line in panel_lines(self._box, labels=self._labels, positions=positions)[:-1]:
            self._screen.say(line)
        claimed: Outcome | None = None
        if task.assessment and percept.joint is not None:
            asked = "What did your last action do? m it moved, n it did not move: "
            claimed = _CLAIMS[self._ask(asked, "MN", situation)]
        order = [self._labels[i] for i in reading_order(self._box)]
        joints = " ".join(label + "*" * (label == task.target) for label in order)
        return Decision(joint=self._ask(f"Which joint? {joints}: ", order, situation), claimed=claimed)

    def _rules(self, situation: Situation) -> None:
        task = situation.task
        for line in _RULES.format(count=len(task.joints), target=task.target, budget=task.budget).splitlines():
            self._screen.say(line)
        self._screen.say(f"The panel: {panel_lines(self._box, positions=[None] * len(self._labels))[-1]}.")
        self._screen.say("Keys: the letter of a joint; ? for help; q to stop.", "dim")

    def _ask(self, question: str, choices: Sequence[str], situation: Situation) -> str:
        while True:
            self._screen.say(question, end="")
            key = _key()
            self._screen.say(key)
            if not key:
                raise Left(f"No letter came for step {len(situation.past) + 1}, and nothing is saved.")
            if key == "Q":
                raise Left(_STOPPED)
            if key == "?":
                self._rules(situation)
            elif key in choices:
                return key
            else:
                self._screen.say(f"Unknown key; press {', '.join(choices)}, ? for help, q to stop.", "yellow")


def _key() -> str:
    """The next key, or the first character of a line that is no terminal's, as a capital; empty at the end of input."""
    if sys.stdin is not None and sys.stdin.isatty():
        try:
            return typer.getchar()[0].upper()
        except EOFError:
            return ""
    return next((line.strip()[0].upper() for line in sys.stdin or () if line.strip()), "")


def _changed(situation: Situation) -> str:
    """The joints whose told position differs from the one told before: what two panels show, and no outcome."""
    now, before = situation.percept.positions, situation.past[-1].percept.positions
    if now is None or before is None:
        return "No positions are told."
    changed = [label for label, *pair in zip(situation.task.joints, now, before, strict=True) if pair[0] != pair[1]]
    return f"Changed on the panel: {', '.join(sorted(changed)) or 'nothing'}."


def _relabelled(box: Lockbox, labels: tuple[str, ...]) -> Lockbox:
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
    for line in interlock_lines(_relabelled(box, trial.labels)):
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
