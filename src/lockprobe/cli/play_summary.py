"""What is told when a box is done: truth beside told, what locked what, and how others did in the same trial."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from lockprobe.cli.printing import Screen
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.sketch import interlock_lines
from lockprobe.lockbox.solve import optimum, random_curve
from lockprobe.record import Trial

__all__ = ["relabelled", "tell"]

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
