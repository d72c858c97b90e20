"""``lockprobe rig``: checks, calibration and rehearsals of a robot before it moves a box."""

from __future__ import annotations

import json as json_
import math
from contextlib import contextmanager
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from lockprobe.boxes.families import DEFAULT_BOX
from lockprobe.boxes.families import find_box as find
from lockprobe.cli import options
from lockprobe.foundation.errors import BadValue, PlantFault, UserMistake
from lockprobe_robot.cli.rig_calibrate import calibrate
from lockprobe_robot.plants import RehearsalRung

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lockprobe_robot.hardware.arm_check import ArmCheck
    from lockprobe_robot.hardware.dry_run import DryMotion, DryRun
    from lockprobe_robot.hardware.rehearsal import Rehearsal, RehearsedAttempt

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)
app.command("calibrate")(calibrate)

_PLANT = options.with_brackets(options.PLANT, "rig?rung=scripted|twin, or your rig as python:MODULE:NAME")
_TWIN = "rig?rung=twin"

NOT_GOOD = 1
"""The exit status if an arm or a rehearsal is not good enough."""


@app.command()
def rehearse(
    rung: Annotated[RehearsalRung, typer.Option(help="How realistic the arm is: scripted or twin.")] = "scripted",
    box: options.Box = DEFAULT_BOX,
    attempts: Annotated[int, typer.Option(min=1, max=10_000, help="Random attempts.")] = 20,
    seed: options.Seed = 1,
    json: options.AsJson = False,
) -> None:
    """Rehearse random attempts with all software but without a robot, and compare the verdicts with the rules.

    Each line is one attempt: the states of the joints in panel order, the joint, whether the rules let it move, the
    verdict, and the greatest force. Exit status 1: a verdict was wrong, or a fault ended an attempt.
    """
    from lockprobe_robot.hardware.rehearsal import rehearse as rehearsed

    with _fault_in_one_line():
        found = rehearsed(rung, find(box), attempts=attempts, seed=seed, tell=(lambda one: None) if json else _tell)
    print(json_.dumps(_facts(found)) if json else "\n".join(_lines(found)))
    if found.right < attempts:
        raise typer.Exit(NOT_GOOD)


@app.command("dry-run")
def dry_run(
    plant: Annotated[str, typer.Option(help=_PLANT)] = _TWIN,
    box: options.Box = DEFAULT_BOX,
    height: Annotated[float, typer.Option(help="Height above the handles, metres, from 0.05 to 0.3.")] = 0.1,
    json: options.AsJson = False,
) -> None:
    """Make every joint's motion above the board, in both directions, without touching it.

    The operator has to agree first. A force of 10 N or a sinking hand stops the arm. Exit status 1: a motion was
    not free.
    """
    import numpy as np

    from lockprobe.foundation.plugins import allow
    from lockprobe.plants.catalogue import resolve_plant
    from lockprobe_robot.hardware.driver_call import call_driver
    from lockprobe_robot.hardware.rig import Rig

    allow(plant)
    asked, source = find(box), resolve_plant(plant)
    with _fault_in_one_line():
        rig = call_driver("the rig", lambda: source.make(asked, asked.names, np.random.default_rng(0)))
        try:
            if not isinstance(rig, Rig):
                raise BadValue("plant", plant, "rig?rung=scripted|twin, or your rig as python:MODULE:NAME")
            found = rig.dry_run(height, (lambda made: None) if json else _tell_motion)
        finally:
            rig.close()
    if json:
        print(json_.dumps({**asdict(found), "facts": dict(found.facts), "complaints": list(found.complaints)}))
    else:
        print("\n".join(_dry(found)))
    if found.complaints:
        raise typer.Exit(NOT_GOOD)


@app.command()
def check(
    host: Annotated[str, typer.Argument(metavar="HOST", help=options.with_brackets(options.HOST, "of the FR3"))],
    commands: Annotated[int, typer.Option(min=10, max=100_000, help="Commands, 10 ms each.")] = 500,
    json: options.AsJson = False,
) -> None:
    """Hold an FR3 in place, and measure success rate and latency of commands before anything moves.

    The arm is switched on but gets no motion command. Exit status 1: the connection is not good enough to move.
    """
    from lockprobe.plants.operator import TerminalOperator
    from lockprobe_robot.hardware.arm_check import check_arm
    from lockprobe_robot.hardware.bounds import Bounded
    from lockprobe_robot.hardware.driver_call import call_driver
    from lockprobe_robot.hardware.franky import FrankyArm
    from lockprobe_robot.hardware.rehearsal import BOUNDS

    with _fault_in_one_line():
        bounded = Bounded(call_driver(f"the FR3 at {host}", lambda: FrankyArm(host)), BOUNDS, TerminalOperator())
        try:
            found = check_arm(bounded, commands=commands)
        finally:
            bounded.stop()
    if json:
        print(json_.dumps({"host": host, **asdict(found), "complaints": list(found.complaints)}))
    else:
        print("\n".join(_checked(host, found)))
    if found.complaints:
        raise typer.Exit(NOT_GOOD)


@contextmanager
def _fault_in_one_line() -> Iterator[None]:
    """Report a fault of a device as a user's mistake, because no trial runs that could end as an error."""
    try:
        yield
    except PlantFault as fault:
        raise UserMistake(str(fault)) from None


def _tell(one: RehearsedAttempt) -> None:
    what = f"fault: {one.fault}" if one.fault else f"{one.verdict}, {one.peak_force:.1f} N"
    mark = "" if one.right or one.fault else "  <- WRONG"
    print(f"{one.state}  {one.joint:16} {'free' if one.free else 'locked':7} {what}{mark}")


def _facts(found: Rehearsal) -> dict[str, object]:
    attempts = [
        {**asdict(one), "peak_force": None if math.isnan(one.peak_force) else one.peak_force, "right": one.right}
        for one in found.attempts
    ]
    return {**asdict(found), "attempts": attempts, "right": found.right}


def _lines(found: Rehearsal) -> list[str]:
    from lockprobe_robot.hardware.rehearsal import RUNGS

    faults = sum(bool(one.fault) for one in found.attempts)
    facts = "".join(f"; {name}: {value}" for name, value in found.facts.items())
    lines = [
        f"Rung: {found.rung}, {RUNGS[found.rung]}{facts}",
        f"Agrees with the rules: {found.right} of {len(found.attempts)} attempts on {found.box}; {faults} faults",
        f"Late commands: {found.commands_late}",
    ]
    if found.right < len(found.attempts) and found.commands_late:
        lines.append("This machine was late, which alone can cause faults: run it again without other load.")
    return lines


def _tell_motion(made: DryMotion) -> None:
    way = f"{made.start} to {1 - made.start}"
    measured = f"force {made.force:.1f} N, off by {1000 * made.astray:.1f} mm, {1000 * made.lowest:.0f} mm above"
    print(f"{made.joint:16} {way}  {made.verdict}, {measured}{'' if made.verdict == 'moved' else '  <- WRONG'}")


def _dry(found: DryRun) -> list[str]:
    from lockprobe_robot.hardware.dry_run import MOST_ASTRAY

    facts, late, right = found.facts, found.facts["late_commands"], len(found.motions) - len(found.complaints)
    force, astray = (max(getattr(one, what) for one in found.motions) for what in ("force", "astray"))
    off = f"Off by: along the handles' paths the hand was at most {1000 * astray:.1f} mm from where it was told to be."
    return [
        f"Rung: {found.rung}, {1000 * found.height:g} mm above the handles of {found.box}; arm: {facts['rung']}",
        f"Free: {right} of {len(found.motions)} motions; greatest force {force:.1f} N; {late} late commands",
        f"{off} Do not touch the board above {1000 * MOST_ASTRAY:g} mm.",
        *(f"Not good enough: {complaint}." for complaint in found.complaints),
    ]


def _checked(host: str, found: ArmCheck) -> list[str]:
    rate = "not reported by this arm" if found.success_rate is None else f"{found.success_rate:.1%}"
    median, most, longest = (f"{1000 * seconds:.1f}" for seconds in found.latency)
    lines = [
        f"Arm: FR3 at {host}",
        f"Commands: {found.commands}, every {1000 * found.period:g} ms; {found.late} late",
        f"Duration: median {median} ms, 95 % within {most} ms, longest {longest} ms",
        f"Success rate: {rate}",
        f"Drift: {1000 * found.drift:.1f} mm; force noise: {found.noise:.2f} N",
    ]
    verdicts = [f"Not good enough: {complaint}." for complaint in found.complaints]
    return [*lines, *(verdicts or ["Good enough to move."])]
