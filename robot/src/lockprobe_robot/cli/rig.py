"""``lockprobe rig``: checks, calibration and rehearsals of a robot before it moves a box."""

from __future__ import annotations

import json as json_
import math
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from lockprobe.boxes.families import DEFAULT_BOX
from lockprobe.boxes.families import find_box as find
from lockprobe.cli import options
from lockprobe.foundation.errors import BadValue, Conflict, PlantFault, UserMistake, needing
from lockprobe.foundation.plugins import ROBOT
from lockprobe_robot.cli.rig_calibrate import calibrate
from lockprobe_robot.cli.rig_tags import tags
from lockprobe_robot.rehearsal_settings import RehearsalRung

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lockprobe_robot.arm.protocol import StoppableArm
    from lockprobe_robot.hardware.arm_check import ArmCheck
    from lockprobe_robot.hardware.dry_run import DryMotion, DryRun
    from lockprobe_robot.hardware.rehearsal import Rehearsal, RehearsedAttempt

__all__ = ["app", "check", "dry_run", "rehearse"]

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)
app.command("tags")(tags)
app.command("calibrate")(calibrate)

_PLANT = options.with_brackets(options.PLANT, "rig?rung=scripted|twin|wire, or your rig as python:MODULE:NAME")
_ARM = "fr3 (franky), panda (panda-py), or wire: a simulated FR3 behind the real client library."

_ARMS = {"fr3": "FR3", "panda": "Panda", "wire": "a simulated FR3 behind the real client library"}

_TWIN = "rig?rung=twin"

ArmKind = Literal["fr3", "panda", "wire"]

_LOADED = "The simulated robot lags where this machine is loaded: run it again without other load."

NOT_GOOD = 1
"""The exit status if an arm or a rehearsal is not good enough."""


@app.command()
def rehearse(
    rung: Annotated[RehearsalRung, typer.Option(help="How realistic the arm is: scripted, twin or wire.")] = "scripted",
    box: options.Box = DEFAULT_BOX,
    attempts: Annotated[int, typer.Option(min=1, max=10_000, help="Random attempts.")] = 20,
    seed: options.Seed = 1,
    json: options.AsJson = False,
) -> None:
    """Rehearse random attempts with all software but without a robot, and compare the verdicts with the rules.

    Each line is one attempt: the states of the joints in panel order, the joint, whether the rules let it move, the
    verdict, and the greatest force. wire needs lockprobe-robot[wire], and an attempt takes about 6 seconds. Exit status
    1: a verdict was wrong, or a fault ended an attempt.
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
                raise BadValue("plant", plant, "rig?rung=scripted|twin|wire, or your rig as python:MODULE:NAME")
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
    arm: Annotated[ArmKind, typer.Option(help=_ARM)] = "wire",
    host: Annotated[str, typer.Option(help=options.with_brackets(options.HOST, "of the robot; wire has none"))] = "",
    commands: Annotated[int, typer.Option(min=10, max=100_000, help="Commands, 10 ms each.")] = 500,
    json: options.AsJson = False,
) -> None:
    """Hold an arm in place, and measure success rate and latency of commands before anything moves.

    The arm is switched on but gets no motion command. Exit status 1: the connection is not good enough to move.
    """
    if bool(host) == (arm == "wire"):
        if host:
            raise Conflict("--host", "--arm wire", "the simulated robot runs here")
        raise BadValue("--host", host, f"the address of the robot for --arm {arm}")
    from lockprobe.plants.operator import ConsentingOperator, TerminalOperator
    from lockprobe_robot.hardware.arm_check import check_arm
    from lockprobe_robot.hardware.bounds import Bounded
    from lockprobe_robot.hardware.rehearsal import BOUNDS

    with _fault_in_one_line():
        raw, close = _open(arm, host)
        try:
            operator = ConsentingOperator() if arm == "wire" else TerminalOperator()
            bounded = Bounded(raw, BOUNDS, operator)
            try:
                found = check_arm(bounded, commands=commands)
            finally:
                bounded.stop()
        finally:
            close()
    if json:
        print(json_.dumps({"arm": arm, **asdict(found), "complaints": list(found.complaints)}))
    else:
        print("\n".join(_checked(_ARMS[arm] + (f" at {host}" if host else ""), found)))
    if found.complaints:
        raise typer.Exit(NOT_GOOD)


def _open(arm: ArmKind, host: str) -> tuple[StoppableArm, Callable[[], None]]:
    """An arm, and the function that releases it."""
    from lockprobe_robot.hardware.driver_call import call_driver

    if arm == "wire":
        import numpy as np

        from lockprobe_robot.hardware.rungs import parts_of

        box = find(DEFAULT_BOX)
        parts = parts_of("wire", box, box.names, np.random.default_rng(0))
        return parts.arm, parts.close
    if arm == "fr3":
        with needing("arms of the type FR3", "fr3", ROBOT):
            from lockprobe_robot.hardware.franky import FrankyArm

        return call_driver(f"the FR3 at {host}", lambda: FrankyArm(host)), lambda: None
    with needing("arms of the type Panda", "panda", ROBOT):
        from lockprobe_robot.hardware.pandapy import PandaArm

    return call_driver(f"the Panda at {host}", lambda: PandaArm(host)), lambda: None


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
    from lockprobe_robot.hardware.rungs import RUNGS

    faults = sum(bool(one.fault) for one in found.attempts)
    facts = "".join(f"; {name}: {value}" for name, value in found.facts.items())
    lines = [
        f"Rung: {found.rung}, {RUNGS[found.rung]}{facts}",
        f"Agrees with the rules: {found.right} of {len(found.attempts)} attempts on {found.box}; {faults} faults",
        f"Late commands: {found.commands_late}",
    ]
    if found.figures:
        lines.append(f"Simulated robot: {found.figures['late']} of {found.figures['ticks']} ticks of 1 ms late")
    if found.right < len(found.attempts) and (found.commands_late or found.figures.get("late")):
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
        *([_LOADED] if facts["rung"] == "wire" and astray > MOST_ASTRAY else []),
        *(f"Not good enough: {complaint}." for complaint in found.complaints),
    ]


def _checked(arm: str, found: ArmCheck) -> list[str]:
    rate = "not reported by this arm" if found.success_rate is None else f"{found.success_rate:.1%}"
    median, most, longest = (f"{1000 * seconds:.1f}" for seconds in found.latency)
    lines = [
        f"Arm: {arm}",
        f"Commands: {found.commands}, every {1000 * found.period:g} ms; {found.late} late",
        f"Duration: median {median} ms, 95 % within {most} ms, longest {longest} ms",
        f"Success rate: {rate}",
        f"Drift: {1000 * found.drift:.1f} mm; force noise: {found.noise:.2f} N",
    ]
    verdicts = [f"Not good enough: {complaint}." for complaint in found.complaints]
    return [*lines, *(verdicts or ["Good enough to move."])]
