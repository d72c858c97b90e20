"""``lockprobe play``: a person plays one trial at a terminal with keys, then sees the truth."""

from __future__ import annotations

import asyncio
import secrets
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
import typer

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.sketch import interlock_lines, panel_lines, reading_order
from lockprobe.boxes.solve import optimum, random_curve
from lockprobe.cli.printing import say
from lockprobe.cli.study_options import with_study_options
from lockprobe.foundation.errors import BadValue, LockprobeError
from lockprobe.foundation.formatting import count
from lockprobe.foundation.spec import PEOPLE
from lockprobe.studies.options.studyfile import trial_study
from lockprobe.studies.running.single import run_trial
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.record import Decision, Fact, Situation, Trial, in_words

OTHERS = ("ideal-observer", "human-inspired", "random")
"""The strategies that play the same trial afterwards."""

_RULES = """\
The box has {count} joints, each in one of two positions. They lock each other in a
hidden way: whether a joint can move depends on the positions of other joints.
In every step you choose one joint. If it is not locked it moves to its other
position; if it is locked, nothing happens. The box is open as soon as the
target joint, {target}, moves. You have {budget} steps.
The panel: {legend}.
Keys: the letter of a joint; ? for help; q to stop."""

_STOPPED = "Stopped; nothing is saved."


class Left(LockprobeError):
    """Raised when the person stops during a trial, or the input ends."""


@with_study_options(only=("box", "p", "seed", "max_steps", "flip", "layout", "shuffle"))
def play(asked: Mapping[str, Any]) -> None:
    """Play a trial yourself, with keys: the same box, reports and budget as any agent; then see the truth.

    Without --p, all reports are true. Without --seed, it is drawn. A letter is an answer. Nothing is saved.
    """
    seed = asked.get("seed", secrets.randbelow(10_000))
    options = {"assessment": False, **asked, "seed": seed}
    study = trial_study(f"{PEOPLE}:local", **options)
    plan = study.plan(study.agents[0], study.conditions[0], 1, 1)
    say(f"Lockbox (--seed {seed} plays this trial again)")
    loop = asyncio.new_event_loop()  # asyncio.run would delay Ctrl-C during the wait for a key
    try:
        trial, _ = loop.run_until_complete(play_timed(plan, Person(plan.box, plan.names.labels)))
    except Left as left:
        say(str(left))
        raise typer.Exit(left.args[0] != _STOPPED) from None
    finally:
        loop.close()
    for line in _truth(trial, plan.box):
        say(line)
    say(f"\nThe same trial played by strategies: same labels, same false reports (seed {seed})")
    say(f"  {'you':24} {_ending(trial)}")
    for spec in OTHERS:
        try:
            how = _ending(run_trial(**{**options, "agent": spec}))
        except BadValue:
            how = "cannot plan for a box of this size"
        say(f"  {spec:24} {how}")
    fewest, curve, steps = optimum(plan.box), random_curve(plan.box, trial.budget), len(trial.steps)
    say(f"  {'fewest possible':24} {'cannot be opened' if fewest is None else count(fewest, 'step')}")
    within = f"{curve[steps]:.1%} of trials within {count(steps, 'step')}, " if steps < trial.budget else ""
    say(f"  Blind choices open the box in {within}{curve[-1]:.1%} within {trial.budget}.")


class Person:
    """The person at the terminal as an agent. It sees the panel of ``box``, not its interlock.

    ``labels`` are in panel order.
    """

    facts: ClassVar[Mapping[str, Fact]] = {}

    def __init__(self, box: Lockbox, labels: Sequence[str]) -> None:
        self._box, self._labels = box, tuple(labels)

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """The person's choice.

        Raises:
            Left: If the person stops, or the input ends.
        """
        task, percept, step = situation.task, situation.percept, len(situation.past) + 1
        legend = panel_lines(self._box, positions=[None] * len(self._labels))[-1]
        rules = _RULES.format(count=len(task.joints), target=task.target, budget=task.budget, legend=legend)
        if step == 1:
            say(rules)
        say(f"\nStep {step} of {task.budget}")
        now = percept.positions or [None] * len(task.joints)
        if percept.joint is not None and percept.outcome:
            say(f"{percept.joint} {in_words(percept.outcome)}.")
        elif percept.joint is not None:  # what two panels show, and no outcome
            before = situation.past[-1].percept.positions
            pairs = zip(task.joints, now, before or (), strict=False)
            changed = ", ".join(sorted(label for label, *pair in pairs if pair[0] != pair[1]))
            known = percept.positions and before
            say(f"You attempted {percept.joint}.")
            say(f"Changed on the panel: {changed or 'nothing'}." if known else "No positions are told.")
        at = dict(zip(task.joints, now, strict=True))
        for line in panel_lines(self._box, labels=self._labels, positions=[at[label] for label in self._labels])[:-1]:
            say(line)
        order = [self._labels[i] for i in reading_order(self._box)]
        joints = " ".join(label + "*" * (label == task.target) for label in order)
        return Decision(joint=_answer(f"Which joint? {joints}: ", order, step, rules))


def _answer(question: str, choices: Sequence[str], step: int, rules: str) -> str:
    """The key of one of these choices: asked for until one comes."""
    while True:
        say(question, end="")
        if sys.stdin is not None and sys.stdin.isatty():
            try:
                key = typer.getchar()[0].upper()
            except EOFError:
                key = ""
        else:  # the first character of a line
            key = next((line.strip()[0].upper() for line in sys.stdin or () if line.strip()), "")
        say(key)
        if not key:
            raise Left(f"No letter came for step {step}, and nothing is saved.")
        if key == "Q":
            raise Left(_STOPPED)
        if key in choices:
            return key
        say(rules if key == "?" else f"Unknown key; press {', '.join(choices)}, ? for help, q to stop.")


def _truth(trial: Trial, box: Lockbox) -> Iterator[str]:
    """The hidden truth of a trial: real outcomes beside the told ones, and the interlock."""
    steps = count(len(trial.steps), "step")
    yield f"\nYou opened the box in {steps}.\n" if trial.solved else f"\nThe box is not open after {steps}.\n"
    yield "step  joint  truth         told"
    label = dict(zip(trial.joints, trial.labels, strict=True))
    for step in trial.steps:
        told = f"{in_words(step.told_moved):12} {'<- false' * step.told_falsely}"
        yield f"{step.step:4}  {label[step.joint]:5}  {in_words(step.moved):14}{told}".rstrip()
    lies = sum(step.told_falsely for step in trial.steps)
    yield f"{lies} of {len(trial.steps)} reports were false (flip rate {trial.p:g})."
    yield "\nThe interlock"
    yield from (f"  {line}" for line in interlock_lines(box, dict(zip(box.names, trial.labels, strict=True))))


def _ending(trial: Trial) -> str:
    return count(len(trial.steps), "step") if trial.solved else f"not within {count(trial.budget, 'step')}"
