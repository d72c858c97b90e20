"""``lockprobe box check``: checks a box file, and a MuJoCo model of the box against its rules."""

from __future__ import annotations

import json as json_
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.boxes.check import fault_of
from lockprobe.boxes.families import find_box
from lockprobe.boxes.observed_moves import Push, corrected
from lockprobe.boxes.solve import optimum
from lockprobe.boxes.state_space import space_of
from lockprobe.cli import options
from lockprobe.cli.robot_tools import robot_tool
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.formatting import count, percent
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.foundation.terminal_text import printable

if TYPE_CHECKING:
    from lockprobe.simulation.exact.propagation import Propagation

__all__ = ["ModelCheck", "check"]

_PRINTED = 10
"""The most disagreements that are printed; --json has all."""

_APART = 0.05
"""Share of the panel, and of the picture, from which one place lies beyond another."""

_STEPS = 20
"""The budget of a trial by default."""

_MANY_STEPS, _MOST_TRIALS = 200, 0.8
"""The longest trial that is looked at, and the share of trials for which its budget should do."""

_SECTION = re.compile(r"\s*\[interlock\]")


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelCheck:
    """What lockprobe-robot found in a model.

    Attributes:
        model: The model's file.
        pushes: Every joint, pushed in every configuration that the model reaches before the target moves.
        dragged: The same with the arm in place of a force; None if the arm was not asked for.
        with_arm: The plant's spec that asks for the arm.
        handle: What the arm can hold, in words.
        handles: Where the picture shows the middle of each handle's travel, in panel order: shares of its width from
            the left and of its height from above.
        out_of_view: Joint -> why the camera does not see where it is.
        picture: A PNG file: what the camera sees, with the names of the joints.
        view: Whose view it is, in words.
        renderer: What drew it.
    """

    model: Path
    pushes: tuple[Push, ...]
    dragged: tuple[Push, ...] | None
    with_arm: str
    handle: str
    handles: tuple[tuple[float, float], ...]
    out_of_view: Mapping[str, str]
    picture: bytes
    view: str
    renderer: str

    @property
    def holds(self) -> bool:
        """Whether every push, and every drag of the arm, went as the rules say."""
        return not any(push.disagreement for push in (*self.pushes, *(self.dragged or ())))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Advice:
    """What to change so that rules and model agree.

    Attributes:
        lines: Joint -> its line of the box file.
        mend: What has to change in the model, in words.
        fault: Why a box with these lines would be refused; empty if it would not.
    """

    lines: Mapping[str, str]
    mend: tuple[str, ...]
    fault: str


def check(
    box: Annotated[str, typer.Argument(metavar="FILE.toml", help="The box file: its rules.")],
    model: Annotated[
        str | None,
        typer.Argument(metavar="FILE.xml", help="A MuJoCo model of the box, or 'twin?model=FILE.xml' with options."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.png",
            help=options.with_brackets(options.OUT, "MODEL-check.png, beside the model"),
        ),
    ] = None,
    json: options.AsJson = False,
) -> None:
    """Check a box file, and a MuJoCo model of the box against its rules.

    Every joint is pushed in every configuration that the model reaches; with arm=yes the robot arm drags it as well.
    Exit status 1: the model differs from the rules; the lines of the file that would agree with it are printed.
    """
    found = find_box(box)
    if out is not None and out.suffix != ".png":
        raise BadValue("--out", str(out), "a file name that ends in .png")
    if model is None:
        print(
            json_.dumps({"box": found.name, "holds": True, **_sizes(found)}) if json else "\n".join(_head(box, found))
        )
        return
    tool = robot_tool("box-check", "checks of a MuJoCo model")
    seen: ModelCheck = tool(found, model)
    out = out or seen.model.with_name(f"{seen.model.stem}{'' if seen.dragged is None else '-arm'}-check.png")
    write_file(out, seen.picture)
    advice = _advice(found, seen.pushes)
    if json:
        print(json_.dumps(_facts(box, found, seen, advice, out)))
    else:
        print("\n".join(map(printable, _lines(box, found, seen, advice, out))))
    raise typer.Exit(0 if seen.holds else 1)


def _sizes(box: Lockbox) -> dict[str, object]:
    reachable = len(space_of(box).reachable)
    return {
        "joints": list(box.names),
        "target": box.target,
        "optimum": optimum(box),
        "reachable": reachable,
        "human_inspired_success": _human_inspired(box).solved[_STEPS],
    }


def _human_inspired(box: Lockbox) -> Propagation:
    from lockprobe.simulation.exact.propagation import propagate

    return propagate("human-inspired", box, max_steps=_MANY_STEPS)


def _head(name: str, box: Lockbox) -> Iterator[str]:
    yield (
        f"{name}: can be played. {len(box.joints)} joints, target {box.target}, optimum {optimum(box)} steps, "
        f"{count(len(space_of(box).reachable), 'configuration')} before {box.target} moves"
    )
    course = _human_inspired(box)
    solved, enough = course.solved[_STEPS], course.by(_MOST_TRIALS)
    more = f"; {percent(_MOST_TRIALS)} need {enough} (--max-steps {enough})" if enough and enough > _STEPS else ""
    yield f"human-inspired, told the truth, solves {percent(solved)} of trials in {_STEPS} steps{more}"


def _advice(box: Lockbox, pushes: Sequence[Push]) -> _Advice:
    from lockprobe.boxes.boxfile import rule_line

    right, left = corrected(box, pushes)
    changed = [name for name in box.names if right.interlock.get(name) != box.interlock.get(name)]
    strange = sum(push.moved is None for push in pushes)
    mend = [f"{name} {why}, and no rule can say that: change the model" for name, why in left.items()]
    if strange:
        mend.append(f"no rule can describe {count(strange, 'push', 'pushes')}: change the model")
    fault = fault_of(right) if changed else None
    return _Advice(
        lines={name: rule_line(name, right.interlock[name]) for name in changed},
        mend=tuple(mend),
        fault=fault.reason if fault else "",
    )


def _lines(name: str, box: Lockbox, seen: ModelCheck, advice: _Advice, out: Path) -> Iterator[str]:
    wrong = [push for push in seen.pushes if push.disagreement]
    yield from _head(name, box)
    yield f"{seen.model}: {_compared(seen.pushes, 'push', 'pushes')}"
    if missing := _not_reached(box, seen):
        yield f"not compared: {count(len(missing), 'configuration')} of the rules, which the model did not reach"
    yield ""
    yield from _table(box, seen.pushes)
    if wrong:
        yield ""
    yield from _differences(box, wrong, "pushed")
    text = read_input(Path(name)).decode("utf-8") if Path(name).is_file() else ""
    for joint, line in advice.lines.items():
        yield f"{_place(name, text, joint)}: {line}"
    yield from advice.mend
    if advice.fault:
        yield f"with these lines the box could not be played ({advice.fault})"
    yield ""
    yield from _of_the_arm(name, box, seen)
    yield f"picture: {out} ({seen.view}, {seen.renderer.partition(' ')[0]})"
    yield from _misplaced(name, box, seen)
    yield from (f"the camera does not see {joint}: {why}" for joint, why in seen.out_of_view.items())
    if not seen.out_of_view:
        yield "the camera sees every joint"


def _compared(pushes: Sequence[Push], one: str, many: str) -> str:
    """How many attempts there were, and how many of them were not as the rules say."""
    tried = len({push.configuration for push in pushes})
    wrong = sum(bool(push.disagreement) for push in pushes)
    found = f"{wrong} not as the rules say" if wrong else "all as the rules say"
    return f"{count(len(pushes), one, many)} in {count(tried, 'configuration')}, {found}"


def _differences(box: Lockbox, wrong: Sequence[Push], done: str) -> Iterator[str]:
    for push in wrong[:_PRINTED]:
        where = f"in {bits(push.configuration)} ({', '.join(box.names)})"
        yield f"differs {where}, {box.names[push.joint]} was {done}: {push.disagreement}"
    if len(wrong) > _PRINTED:
        yield f"and {len(wrong) - _PRINTED} more (--json)"


def _of_the_arm(name: str, box: Lockbox, seen: ModelCheck) -> Iterator[str]:
    """What the arm did, or the command that lets it try."""
    if seen.dragged is None:
        yield f"the arm was not tried: lockprobe box check {quote(name)} {quote(seen.with_arm)}"
        return
    yield f"the arm: {_compared(seen.dragged, 'drag', 'drags')}"
    if wrong := [push for push in seen.dragged if push.disagreement]:
        yield from _differences(box, wrong, "dragged")
        yield f"what the arm needs: {seen.handle}"


def _misplaced(name: str, box: Lockbox, seen: ModelCheck) -> Iterator[str]:
    """One line for each direction in which the places of the file follow another order than the picture's."""
    ways = (("left to right", 0, 1), ("top to bottom", 1, -1))
    for way, axis, sign in ways:
        told = [sign * joint.place[axis] for joint in box.joints]
        shown = [place[axis] for place in seen.handles]
        swapped = any(
            told[other] - told[one] > _APART and shown[one] - shown[other] > _APART
            for one, other in permutations(range(len(told)), 2)
        )
        if swapped:
            said, there = (", ".join(np.array(box.names)[np.argsort(at, kind="stable")]) for at in (told, shown))
            yield f"places differ from {way}: {name} says {said}; the picture shows {there}"


def _table(box: Lockbox, pushes: Sequence[Push]) -> Iterator[str]:
    """For each joint the pushes that agree, by what happened, and those that do not."""
    wide = max(map(len, (*box.names, "joint")))
    yield f"{'joint':{wide}}  moved  held  differs"
    for joint, name in enumerate(box.names):
        own = [push for push in pushes if push.joint == joint]
        agreed = [push for push in own if not push.disagreement]
        moved = sum(bool(push.moved) for push in agreed)
        yield f"{name:{wide}}  {moved:5}  {len(agreed) - moved:4}  {len(own) - len(agreed):7}"


def _place(name: str, text: str, joint: str) -> str:
    """Where a rule is written in a box file, in words."""
    inside, section = False, False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("["):
            inside = bool(_SECTION.match(line))
            section |= inside
        elif inside and re.match(rf"""\s*["']?{re.escape(joint)}["']?\s*=""", line):
            return f"change line {number} of {name}"
    return f"add to {name}{', below [interlock]' if section else ', in [interlock]'}"


def _not_reached(box: Lockbox, seen: ModelCheck) -> list[Configuration]:
    """Configurations that are reachable by the rules, and not in the model."""
    tried = {push.configuration for push in seen.pushes}
    by_rules = (
        tuple(bool(number >> joint & 1) for joint in range(len(box.joints))) for number in space_of(box).reachable
    )
    return [configuration for configuration in by_rules if configuration not in tried]


def _facts(name: str, box: Lockbox, seen: ModelCheck, advice: _Advice, out: Path) -> dict[str, object]:
    return {
        "box": box.name,
        "holds": seen.holds,
        **_sizes(box),
        "model": str(seen.model),
        **_counts(box, seen.pushes),
        "not_reached": [bits(configuration) for configuration in _not_reached(box, seen)],
        "arm": None if seen.dragged is None else _counts(box, seen.dragged),
        "lines": dict(advice.lines),
        "mend": list(advice.mend),
        "fault": advice.fault or None,
        "misplaced": [*_misplaced(name, box, seen)],
        "out_of_view": dict(seen.out_of_view),
        "picture": str(out),
        "view": seen.view,
        "renderer": seen.renderer,
    }


def _counts(box: Lockbox, pushes: Sequence[Push]) -> dict[str, object]:
    """How many attempts there were, and those that were not as the rules say."""
    return {
        "pushes": len(pushes),
        "configurations": len({push.configuration for push in pushes}),
        "differ": [
            {
                "configuration": bits(push.configuration),
                "joint": box.names[push.joint],
                "allowed": push.allowed,
                "moved": push.moved,
                "said": push.disagreement,
            }
            for push in pushes
            if push.disagreement
        ],
    }
