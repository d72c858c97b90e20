"""Whole trials over the wire against the symbolic box: the same agent, the same luck, step by step.

    uv run --all-packages --extra wire --extra realsense python benchmarks/wire_trial.py [--rung wire] [--out wire]

One trial of ``human-inspired`` without false reports and one at a flip rate of 0.4. The trials over the wire
are recorded in the directory; films of them: ``lockprobe replay DIR KEY --out film.gif``.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import flips
from lockprobe.studies.running.runner import run_study
from lockprobe.studies.study import Study
from lockprobe.trial.record import Step, Trial


def main() -> None:
    """Play on both, and print every step."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--rung", default="wire", choices=["scripted", "twin", "wire"])
    parser.add_argument("--truth", default="camera", choices=["camera", "simulation"])
    parser.add_argument("--box", default="chain-4")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("wire"))
    asked = parser.parse_args()
    study = Study(
        name="flips",
        agents=("human-inspired",),
        box=box(asked.box),
        conditions=flips((0.0, 0.4)),
        seed=asked.seed,
        repetitions=1,
        trials=1,
        plant=f"rig?rung={asked.rung}&truth={asked.truth}",
    )
    rehearsed = run_study(study, asked.out)
    with tempfile.TemporaryDirectory() as elsewhere:
        ruled = run_study(replace(study, plant="symbolic"), Path(elsewhere))
    for ours, theirs in zip(rehearsed, ruled, strict=True):
        _compare(ours, theirs)


def _compare(ours: Trial, theirs: Trial) -> None:
    print(f"{ours.key}: {ours.ending} after {len(ours.steps)} steps; {_said(ours.plant)}")
    if ours.error is not None:
        print(f"  {ours.error.boundary}: {ours.error.message}")
    equal = 0
    for one, other in zip(ours.steps, theirs.steps, strict=False):
        same = _seen(one) == _seen(other)
        equal += same
        sensed = one.sensed
        print(
            f"  {one.step:2}  {one.state}  {one.joint:15} {'moved' if one.moved else 'blocked':8} "
            f"told {'moved' if one.told_moved else 'blocked':8} {'equal' if same else f'DIFFERENT: {_seen(other)}'}; "
            f"verdict {sensed['verdict']}, {sensed['peak_force']:.1f} N, {sensed['seconds']:.1f} s"
        )
    print(f"  {equal} of {len(theirs.steps)} steps as on the symbolic box, where it is {theirs.ending}")


def _seen(step: Step) -> tuple[object, ...]:
    return step.state, step.joint, step.moved, step.told_moved, step.told_state, step.told


def _said(facts: Mapping[str, object]) -> str:
    return ", ".join(
        f"{name} {facts[name]}" for name in ("rung", "truth", "camera", "driver", "robot") if name in facts
    )


if __name__ == "__main__":
    main()
