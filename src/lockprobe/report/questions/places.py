"""What places give away to those who see where joints lie: people, and agents that see pictures or read places."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.solve import optimum
from lockprobe.foundation.formatting import percent
from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.rows import Estimate, Results, Row
from lockprobe.report.section import Part, Section
from lockprobe.studies.modality import shows_places

_MOST = 400
"""Blocks whose panels are looked at: the first of a study."""


_REACHED, _STEPS = "reached from right to left", "steps from right to left"
"""How many boxes of the study the rule opens in the fewest steps, and the steps that it takes on average."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    study = numbers.study
    if not (PEOPLE in study.agents or any(map(shows_places, study.modalities))):
        return
    who, condition = study.agents[0], study.conditions[0]
    blocks = [block for _, block in zip(range(_MOST), study.blocks_of(who), strict=False)]
    boxes = [study.plan(who, condition, *block).box for block in blocks]
    steps = [steps_from_right(box, study.max_steps) for box in boxes]
    least = [taken == optimum(box) for box, taken in zip(boxes, steps, strict=True)]
    found = partial(Estimate, quantity="optimum", n=len(boxes))
    yield found(of=_REACHED, value=sum(least) / len(boxes), count=sum(least))
    yield found(of=_STEPS, unit="steps", value=sum(steps) / len(boxes))


def steps_from_right(box: Lockbox, budget: int) -> int:
    """The steps in which a box opens whose joints are attempted from right to left, again and again; at most a budget.

    This is what the agent ``right-to-left`` needs, whatever it is told.

    >>> from lockprobe.boxes.families import box
    >>> steps_from_right(box("chain-4"), 20)
    4
    """
    order = sorted(range(len(box.joints)), key=lambda joint: box.joints[joint].place, reverse=True)
    here, target = box.initial, box.target_index
    for step in range(budget):
        joint = order[step % len(order)]
        here, moved = box.attempt(here, joint)
        if moved and joint == target:
            return step + 1
    return budget


def _show(found: Results) -> Iterator[Part]:
    least, steps = (found.get("optimum", of=of) for of in (_REACHED, _STEPS))
    if least and steps:
        said = f"opens {percent(least.value)} of the boxes in the fewest possible steps, {steps.value:.1f} on average."
        yield Part(
            "What do places give away?",
            f"Whoever takes the joints from right to left, whatever is reported, {said}",
            ["Places are seen in this study. The agent right-to-left plays the rule, again and again."],
        )


SECTIONS = (Section(name="places", title="Places", rows=_rows, show=_show),)
