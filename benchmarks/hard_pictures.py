"""How often the viewer misreads pictures that are harder: ``python benchmarks/hard_pictures.py [--tilts]``.

The random agent plays on ``fast-twin`` with every option of its pictures, on dealt panels of boxes of four and five
joints. The same frames are shown in three modalities, and viewers of three acuities read them. Printed are two shares
in percent: of joints whose position is misread, over all pictures, and of actions whose outcome is misread, which is
what Table 1 counts. ``--tilts`` compares kinds of depth, without colours, at several tilts of the board instead;
``--panels`` prints the lines of every box.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from degraded import percepts_of, photographed

from lockprobe.agents.strategies import RandomAgent
from lockprobe.agents.viewer import Eyesight, Viewer
from lockprobe.boxes.families import box
from lockprobe.boxes.layouts import redealt
from lockprobe.foundation.seeds import trial_stream
from lockprobe.trial.plan import Names

BOXES = ("chain-4", "branched", "random-5-1")
HARD = (
    "board=bare&handle_colours=plain&view_jitter=3&view_turn=0.5&light=side&colours=drawn&viewpoint=oblique&clutter=12"
)
PICTURES = {
    "today": "", "discs": "discs=no", "bare": "board=bare", "labels": "labels=no",
    "plain handles": "handle_colours=plain",
    "bare, plain": "board=bare&handle_colours=plain", "jitter 3 mm": "view_jitter=3", "jitter 10 mm": "view_jitter=10",
    "turn 0.5": "view_turn=0.5", "turn 1": "view_turn=1", "turn 2": "view_turn=2", "side": "light=side",
    "dim": "light=dim", "second": "colours=second", "drawn": "colours=drawn", "oblique": "viewpoint=oblique",
    "ball": "handle_shape=ball", "square": "handle_shape=square", "hollow": "handle_shape=hollow",
    "clutter 6": "clutter=6", "clutter 12": "clutter=12", "all hard": HARD, "all hard, varied": f"{HARD}&looks=varied",
}  # fmt: skip
DEGRADED = ("", "noise=0.1", "exposure=-4", "exposure=2")
MODALITIES = ("rgb", "rgbd?depth=turbo", "rgbd?depth=height")
ACUITIES: tuple[int | None, ...] = (10, 64, None)
TILTS = {
    **{f"tilt {tilt}": f"tilt={tilt}" for tilt in (0, 20, 40, 60)},
    "tilt 20, noise": "tilt=20&depth_noise=0.002", "tilt 20, oblique": "tilt=20&viewpoint=oblique",
}  # fmt: skip
DEPTH_ALONE: dict[str, Any] = {"acuities": (10, 16, 24, 64, None), "kinds": ("depth",)}

Shares = dict[tuple[str, int | None], tuple[list[bool], list[bool]]]
"""Modality and acuity -> which positions, and which outcomes, are misread."""


def misread(
    plant: str,
    name: str,
    trials: Sequence[int],
    modalities: Sequence[str],
    into: Shares,
    *,
    acuities: Sequence[int | None] = ACUITIES,
    kinds: Sequence[str] = ("rgb", "depth"),
) -> None:
    """Add what is misread in some trials on dealt panels of a box, in these kinds of pictures."""
    for trial in trials:
        panel = redealt(box(name), trial_stream(1, 1, trial, "layout"))
        played, plan, seen = photographed(trial, plant, panel)
        order = Names(plan).order
        states = [step.state for step in played.steps]
        truth = np.array([[int(state[i]) for i in order] for state in states])
        for modality in modalities:
            percepts = percepts_of(plan, seen, modality)
            percepts = [replace(p, pictures=tuple(x for x in p.pictures if x.kind in kinds)) for p in percepts]
            for acuity in acuities:
                viewer = Viewer(strategy=RandomAgent(), name="random", sight=Eyesight(acuity=acuity))
                reports = viewer.reports(Names(plan).task(plan), percepts)
                positions, outcomes = into[modality, acuity]
                read = np.array([report.positions for report in reports[: len(truth)]])
                positions.extend((read != truth).ravel().tolist())
                outcomes.extend(
                    (report.outcome == "moved") != step.moved
                    for report, step in zip(reports[1:], played.steps, strict=True)
                )


def line(title: str, found: Shares) -> str:
    """A line of the table."""
    cells = [
        f"{100 * np.mean(positions):6.1f} {100 * np.mean(outcomes):5.1f}" for positions, outcomes in found.values()
    ]
    return f"{title:24}" + " |".join(cells)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=1, help="of every box")
    parser.add_argument("--only", default="", help="lines whose names contain this")
    parser.add_argument("--tilts", action="store_true")
    parser.add_argument("--panels", action="store_true")
    asked = parser.parse_args()
    lines = {title: (f"fast-twin?{options}".rstrip("?"), MODALITIES) for title, options in PICTURES.items()}
    for degraded in DEGRADED[1:]:
        lines[degraded] = ("fast-twin", tuple(f"{m}{'&' if '?' in m else '?'}{degraded}" for m in MODALITIES))
    if asked.tilts:
        kinds = tuple(f"rgbd?depth={kind}" for kind in ("turbo", "gray", "height"))
        lines = {tilt: (f"fast-twin?{options}", kinds) for tilt, options in TILTS.items()}
    print("columns: modality x acuity; positions and outcomes misread, %")
    for title, (plant, modalities) in lines.items():
        if asked.only not in title:
            continue
        total: Shares = defaultdict(lambda: ([], []))
        for number, name in enumerate(BOXES):
            trials = range(number * asked.trials + 1, (number + 1) * asked.trials + 1)  # other luck for every box
            found: Shares = defaultdict(lambda: ([], []))
            misread(plant, name, trials, modalities, found, **(DEPTH_ALONE if asked.tilts else {}))
            for key, (positions, outcomes) in found.items():
                total[key][0].extend(positions)
                total[key][1].extend(outcomes)
            if asked.panels:
                print(line(f"  {title} {name}", found), flush=True)
        actions = len(next(iter(total.values()))[1])
        print(line(title, total), f"({actions} actions)", flush=True)


if __name__ == "__main__":
    main()
