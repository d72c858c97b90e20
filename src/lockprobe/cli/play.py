"""``lockprobe play``: one trial in the terminal, and what the player could not know after it."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.agents.participant import participant_spec
from lockprobe.cli.person import Ended, Keys, Left, Person, ViewKind
from lockprobe.cli.printing import Screen
from lockprobe.errors import BadFile, BadValue
from lockprobe.inputs import check_regular
from lockprobe.interventions.flip import FlipKind
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.families import DEFAULT_BOX
from lockprobe.lockbox.sketch import interlock_lines
from lockprobe.lockbox.solve import optimum, random_curve
from lockprobe.plan import Names, Plan
from lockprobe.record import Trial
from lockprobe.storage.jsonl import LineFile
from lockprobe.studies.play import play_timed
from lockprobe.studies.single import run_trial
from lockprobe.studies.study import LayoutKind
from lockprobe.studies.studyfile import trial_study
from lockprobe.studies.trial_options import TrialOptions
from lockprobe.trial_json import trial_to_json

__all__ = ["play", "relabelled", "tell"]

OTHERS = ("ideal-observer", "human-inspired", "random")
"""Who plays the same trial afterwards."""

_SEEDS = 10_000
"""A seed that nobody asked for is one of so many."""


def play(
    box: Annotated[str, typer.Option(help="A box by name, random-N-SEED, or a TOML file.")] = DEFAULT_BOX,
    p: Annotated[float, typer.Option(help="Flip rate: how often reports are false.")] = 0.0,
    flip: Annotated[FlipKind, typer.Option(help="How long a false report lasts.")] = "transient",
    seed: Annotated[int | None, typer.Option(help="Seed of everything (drawn).")] = None,
    max_steps: Annotated[int, typer.Option(help="Budget in steps.")] = 20,
    layout: Annotated[LayoutKind, typer.Option(help="fixed; shuffled: a new panel.")] = "fixed",
    shuffle: Annotated[bool, typer.Option("--shuffle/--no-shuffle", help="Shuffle labels and their listing.")] = True,
    assessment: Annotated[
        bool, typer.Option("--assessment/--no-assessment", help="Ask what the last action did.")
    ] = True,
    view: Annotated[
        ViewKind, typer.Option(help="Show reports as a drawing, or as the text that models read.")
    ] = "panel",
    record: Annotated[
        Path | None, typer.Option(metavar="FILE.jsonl", help="Append the trial to this file, as studies record it.")
    ] = None,
) -> None:
    """Play a trial yourself, with keys: the same box, reports and budget as any agent; then see what was true."""
    seed = secrets.randbelow(_SEEDS) if seed is None else seed
    if record is not None:
        _check_record(record)
    asked: TrialOptions = {
        "box": box, "p": p, "flip": flip, "seed": seed, "max_steps": max_steps, "layout": layout, "shuffle": shuffle,
        "assessment": assessment,
    }  # fmt: skip
    study = trial_study(asked, agent=participant_spec("local"))
    plan = study.plan(study.agents[0], study.conditions[0], 1, 1)
    screen = Screen()
    screen.say(f"Lockbox (--seed {seed} plays this trial again)", "bold")
    try:
        trial = _played(plan, view, screen)
    except Ended:
        screen.say("The input ended before the trial did; nothing is kept.")
        raise typer.Exit(1) from None
    except Left:
        screen.say("Stopped; nothing is kept.")
        return
    except KeyboardInterrupt:
        screen.say()
        raise
    if record is not None:
        _append(record, trial)
    others = {spec: _of(spec, asked) for spec in OTHERS}
    tell(screen, trial, plan.box, others)
    if record is not None:
        screen.say(f"Recorded: {record}")


def _played(plan: Plan, view: ViewKind, screen: Screen) -> Trial:
    """Not through asyncio.run: it would keep Ctrl-C to itself while a key is waited for."""
    loop = asyncio.new_event_loop()
    try:
        with Keys() as keys:
            person = Person(plan.box, Names(plan).labels, view, keys, screen)
            return loop.run_until_complete(play_timed(plan, person, lambda key, step: None))[0]
    finally:
        loop.close()


def _of(spec: str, asked: TrialOptions) -> Trial | None:
    """A strategy in the same trial; None if the box is too large for it."""
    try:
        player: TrialOptions = {**asked, "agent": spec}
        return run_trial(**player)
    except BadValue:
        return None


def _check_record(path: Path) -> None:
    """Refuse a file to which nothing could be appended after the trial, and leave none behind."""
    if not path.absolute().parent.is_dir():
        raise BadFile(path, "its directory does not exist")
    check_regular(path)
    there = path.exists()
    try:
        path.open("ab").close()
    except OSError as error:
        raise BadFile(path, f"cannot be written ({error.strerror})") from None
    if not there:
        path.unlink()


def _append(path: Path, trial: Trial) -> None:
    with closing(LineFile(path)) as file:
        if not file.left.tail.endswith(b"\n") and file.left.size:
            file.append(b"")  # a last line without its end is ended, so that this one starts clean
        file.append(trial_to_json(trial))


_WORDS = {True: "moved", False: "did not move", None: "nothing"}


def relabelled(box: Lockbox, labels: tuple[str, ...]) -> Lockbox:
    """The same box with its joints called by the labels that its player knew, in panel order."""
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
    """Say all that the player could not know.

    Args:
        screen: Where.
        trial: What was played.
        box: The box of this trial.
        others: The same trial of strategies, by spec; None for one that cannot play this box.
    """
    steps = len(trial.steps)
    screen.say()
    if trial.solved:
        screen.say(f"You opened the box in {_steps(steps)}.", "bold green")
    else:
        screen.say(f"The box is not open after {_steps(steps)}.", "bold yellow")
    screen.say()
    _story(screen, trial)
    screen.say()
    screen.say("What locks what", "bold")
    for line in interlock_lines(relabelled(box, trial.labels)):
        screen.say("  " + line)
    screen.say()
    screen.say(f"The same trial of others: same labels, same false reports (seed {trial.seed})", "bold")
    for who, how in _standing(trial, box, others):
        screen.say(f"  {who:24} {how}")
    curve = random_curve(box, trial.budget)
    within = f"{curve[steps]:.1%} of trials within {_steps(steps)}, " if steps < trial.budget else ""
    screen.say(f"  Blind choices open the box in {within}{curve[-1]:.1%} within {trial.budget}.")


def _steps(number: int) -> str:
    return f"{number} step{'s' * (number != 1)}"


def _story(screen: Screen, trial: Trial) -> None:
    asked = trial.assessment and len(trial.steps) > 1
    screen.say(f"step  joint  {'truth':14}{'told':14}{'you then said' if asked else ''}".rstrip(), "bold")
    label = dict(zip(trial.joints, trial.labels, strict=True))
    said = [step.decision.claimed for step in trial.steps[1:]] + [None]
    for step, claimed in zip(trial.steps, said, strict=True):
        false = step.told_falsely
        then = "" if claimed is None else _WORDS[claimed == "moved"]
        line = f"{step.step:4}  {label[step.joint]:5}  {_WORDS[step.moved]:14}{_WORDS[step.told_moved]:14}{then:14}"
        screen.say((line + "<- false" * false).rstrip(), "red" if false else "")
    lies = sum(step.told_falsely for step in trial.steps)
    screen.say(f"{lies} of {len(trial.steps)} reports were false (flip rate {trial.p:g}).")
    if asked:
        pairs = list(zip(trial.steps, said, strict=True))[:-1]
        right = sum((claimed == "moved") == step.moved for step, claimed in pairs)
        screen.say(f"What you said of your actions was true {right} of {len(pairs)} times.")


def _standing(trial: Trial, box: Lockbox, others: dict[str, Trial | None]) -> Iterator[tuple[str, str]]:
    yield "you", _ending(trial)
    for spec, played in others.items():
        yield spec, "cannot think through a box of this size" if played is None else _ending(played)
    fewest = optimum(box)
    yield "fewest possible", "cannot be opened" if fewest is None else _steps(fewest)


def _ending(trial: Trial) -> str:
    return _steps(len(trial.steps)) if trial.solved else f"not within {_steps(trial.budget)}"
