"""``lockprobe power``: how many trials, boxes or persons a design needs."""

from __future__ import annotations

import json as json_
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Annotated, Any

import typer

from lockprobe.cli import options
from lockprobe.cli.printing import print_rows, time_left
from lockprobe.cli.study_options import study_help, with_study_options
from lockprobe.foundation.errors import BadValue, Conflict
from lockprobe.foundation.workers import Processes
from lockprobe.studies.power import PAPER, TARGET, Clusters, Effect, Needed, conditions_of
from lockprobe.studies.power import power as simulated

_WHAT = "why: a study of controls; a study file: its conditions, and how many agents; trials per condition (flips)."
_SUCCESS = (
    "Effect: success under each condition in the order of the study, as 0.2,0.5,0.4, the control first; for flip rates "
    "0 to 0.6 a rise and fall; for why: truth, lie, truth-truth, lie-truth, truth-lie, lie-lie, remark."
)
_PEOPLE = "A study of people (how many persons it needs, within and between persons; with --success)."
_PERSONS = "With --people: persons in all at which power is measured, as 40 or 40,80 (10 to 160 for each condition)."
_BOXES = "With --people: boxes that a person plays under each condition (1)."
_OVER_BOXES = "Numbers of boxes to measure at, as 5,10,20, by --trials on each (none; with --success)."
_TRIALS = study_help(
    "trials", "numbers to measure at: 15,30,60,120,240; of why 50,150,300,600; on each box 1,2,5,10,20"
)

_FACTORS = (0.5, 1.0, 1.5)
"""What the assumed deviations between persons are multiplied by, to show how much they decide."""

_BOX_SD = 0.6
"""Deviations between boxes, in logits: about 15 points of success, and of its change, around one half; by eye."""


@with_study_options(without=("boxes", "trials", "strategy_trials", "repetitions", "full", "until"))
def power(
    asked: Mapping[str, Any],
    what: Annotated[str | None, typer.Argument(metavar="[why|FILE.toml]", help=_WHAT)] = None,
    success: Annotated[str | None, typer.Option(help=_SUCCESS)] = None,
    trials: Annotated[str | None, typer.Option(help=_TRIALS)] = None,
    people: Annotated[bool, typer.Option("--people", help=_PEOPLE)] = False,
    persons: Annotated[str | None, typer.Option(help=_PERSONS)] = None,
    boxes_each: Annotated[int | None, typer.Option(min=1, max=1000, help=_BOXES)] = None,
    over_boxes: Annotated[str | None, typer.Option(help=_OVER_BOXES)] = None,
    studies: Annotated[int, typer.Option(min=1, max=100_000, help="Simulated studies of each kind (100).")] = 100,
    json: options.AsJson = False,
) -> None:
    """Find by simulation how large a study has to be to detect a given effect with a power of 0.8.

    Every condition is judged as the report judges it: in pairs of equal luck, corrected for the conditions of its
    family and for the agents. Success is --success; without it, a rise and fall like the paper's over its flip rates
    (0.23 at 0, 0.67 at 0.4, then 0.5). power why: how many blocks a study of controls needs to name the reason for a
    change of success.

    --over-boxes: how many boxes, with --trials on each, show the change on boxes like these.

    --people: how many persons a study of people needs, within and between persons; with --persons, the power of that
    many.
    """
    form = "--people" if people else "--over-boxes" if over_boxes else "power"
    takes = {"--people": ("persons", "boxes_each"), "--over-boxes": ("trials",), "power": ("trials", *asked)}[form]
    own = {"persons": persons, "boxes_each": boxes_each, "trials": trials}
    given = [*asked, *(name for name, value in own.items() if value is not None)]
    refused = [f"--{name.replace('_', '-')}" for name in given if name not in (*takes, "seed")]
    if refused or (what and form != "power") or (people and over_boxes):
        raise Conflict(form, ", ".join(refused) or what or "--over-boxes", "they describe another design")
    shares, sizes, seed = _numbers("success", success), _numbers("trials", trials, int), asked.get("seed", 1)
    processes = min(os.cpu_count() or 1, 8)
    pool = Processes(processes) if processes > 1 else None
    effects: Sequence[Effect]
    if people:
        model, sizes = Clusters(success=tuple(shares), each=boxes_each or 1), _numbers("persons", persons, int)
        effects = [
            replace(model, between=between, sd=model.sd * factor, effect_sd=model.effect_sd * factor)
            for between in (False, True)
            for factor in _FACTORS
        ]
        note = (
            "Persons in all. sd, effect sd: standard deviations between persons, in logits, of skill and of the effect "
            "of a condition, chosen by eye: plan with the worst row until a pilot has measured them. Persons who leave "
            "come on top. Assumption: nobody learns from box to box."
        )
    elif over_boxes:
        deviations: dict[str, Any] = {"counted": "boxes", "sd": _BOX_SD, "effect_sd": _BOX_SD}
        effects = [Clusters(success=tuple(shares), each=each, **deviations) for each in sizes or (1, 2, 5, 10, 20)]
        sizes = _numbers("over-boxes", over_boxes, int)
        note = (
            "Boxes, for a sentence on boxes like these. sd, effect sd: standard deviations between boxes, in logits, "
            f"of success and of its change, by eye: {_BOX_SD:g} is about 15 points around one half."
        )
    else:
        from lockprobe.studies.options.studyfile import study

        if what is None and asked.keys() <= {"seed"}:
            shares, asked = shares or [*PAPER], {**asked, "p": [i / 10 for i in range(len(PAPER))]}
        named = {"agent": "random", **asked} if what is None else asked  # an agent is named that nobody plays
        effects = conditions_of(study(what or "flips", **named), shares)
        note = (
            "Trials under each condition. choices: comparisons that are corrected together. Where success equals the "
            "control's, the share is of false positives. Assumption: trials share no luck."
        )
    found = simulated(effects, sizes, studies=studies, seed=seed, workers=pool, progress=time_left("batches"))
    rows = [
        one.row(detected) | {one.counted: needed}
        for one, each in zip(effects, found, strict=True)
        for detected, needed in each.items()
    ]
    if json:
        found_here = {"target": TARGET, "studies": studies, "seed": seed, "rows": rows}
        print(json_.dumps(found_here, indent=1, default=asdict))
    elif rows:
        cells = [dict(cell for name, value in row.items() for cell in _cells(name, value)) for row in rows]
        print_rows([[*cells[0]], *([*row.values()] for row in cells)])
        print(f"\n{note}")
    else:
        print("Nothing was concluded in any study.")


def _cells(name: str, value: object) -> Iterable[tuple[str, str]]:
    """Columns of a row with their cells: what is needed has one for every size measured, and one for the answer."""
    if not isinstance(value, Needed):
        yield name, "" if value is None else f"{value:.3g}" if isinstance(value, float) else str(value)
        return
    yield from ((f"n={one.n}", f"{one.power:.2f}±{one.error:.2f}") for one in value.measured)
    least, most = value.measured[0].n, value.measured[-1].n
    said = f"{value.needed} [{value.low or f'at most {least}'}, {value.high or f'more than {most}'}]"  # 95 % interval
    if value.needed in (None, least):
        said = f"more than {most}" if value.needed is None else f"at most {least}"
    yield f"{name} for {TARGET:g}", said


def _numbers(name: str, text: str | None, kind: type[int | float] = float) -> list[Any]:
    """Numbers separated by commas; none of no text."""
    try:
        return [kind(part) for part in text.split(",")] if text is not None else []
    except ValueError:
        raise BadValue(name, text, f"{'whole ' * (kind is int)}numbers separated by commas") from None
