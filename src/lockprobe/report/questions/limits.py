"""What limits the numbers: trials that broke, what is known whatever became of them, and what no number shows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import median
from typing import Any

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.solve import optimum
from lockprobe.foundation.formatting import count, percent
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import PEOPLE, Spec
from lockprobe.report.answer import BEFORE, known_of_broken
from lockprobe.report.opened import OpenedStudy, PlayedCell
from lockprobe.report.questions.boxes import boxes_said
from lockprobe.report.questions.loops import LENGTHS
from lockprobe.report.rows import PERMUTED, Estimate, Fact, Results, Row, measured_row
from lockprobe.report.section import Part, Section, Template
from lockprobe.statistics.differences import differences_before_breaks, few_broke_until
from lockprobe.statistics.every_look import E_PROCESS
from lockprobe.studies.modality import shows_places
from lockprobe.trial.record import Trial


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    """By agent and boundary, with the first message, and whether the first of them will be replayed."""
    broken = grouped(
        (trial for trial in numbers.trials if trial.error is not None),
        lambda trial: (trial.group, str(trial.error.boundary) if trial.error else ""),
    )
    for (agent, boundary), trials in sorted(broken.items()):
        yield Estimate(quantity="broken", agent=agent, of=boundary, value=len(trials), unit="trials")
        facts = {"first message": _message(trials[0]), "will be replayed": "yes" if trials[0].owed_again else "no"}
        yield from (Fact(about=f"{agent}, broken at {boundary}", name=name, text=text) for name, text in facts.items())
    of_agents = grouped(numbers.cells, lambda cell: (cell.agent, cell.modality)).values()
    broke = [cells for cells in of_agents if any(cell.outcomes.broke.any() for cell in cells)]
    for cells in broke:
        yield from _of_agent(cells, len(broke))


def _of_agent(cells: Sequence[PlayedCell], agents: int) -> Iterator[Estimate]:
    """When the trials of an agent broke and ended, and every condition against the first by an early step.

    The step is the last one by which few trials of each condition broke. At every look it can be another one; what is
    said then allows for all steps of the budget.
    """
    of: dict[str, Any] = {"agent": cells[0].agent, "modality": cells[0].modality}
    broke = [steps + 1 for cell in cells for steps in cell.outcomes.broken.length.tolist()]
    finished = [steps for cell in cells for steps in cell.ended.length.tolist()]
    for part, steps in (("broken", broke), ("ended", finished)):
        if steps:
            yield Estimate(quantity="last_step", **of, of=part, unit="steps", value=median(steps), n=len(steps))
    cells = [cell for cell in cells if len(cell.ended)]
    groups = [cell.outcomes for cell in cells]
    budget, step = max((one.budget for one in groups), default=0), few_broke_until(groups)
    yield Estimate(quantity="last_step", **of, of="few broke", unit="steps", value=step)
    if len(cells) < 2 or not 0 < step < budget:
        return
    first, order = cells[0].trials[0], cells[0].order
    many = agents if order is None else agents * budget
    rng = generator(first.seed, "analysis", first.spec, first.modality, BEFORE)
    found = differences_before_breaks(groups, step, rng, agents=many)
    test = "McNemar, and interval" if order is None else E_PROCESS
    for place, one in found:
        yield measured_row(
            "success_difference", one, **cells[place].of, control=first.condition, of=BEFORE, unit="points",
            n=one.first.n, family=f"success {BEFORE}", corrected_for=len(found) * many,
            test=test if one.only else PERMUTED,
        )  # fmt: skip


def _message(trial: Trial) -> str:
    """What was said; of an agent that has a name without its spec, which may hold a path."""
    said = "" if trial.error is None else trial.error.message
    for written in (trial.spec, Spec.parse(trial.spec).name.removeprefix("gguf:")) if trial.called else ():
        said = said.replace(written, trial.called) if written else said
    return said


def _show(found: Results) -> Iterator[Part]:
    rows = [(row, found.facts_about(f"{row.agent}, broken at {row.of}")) for row in found.where("broken", condition="")]
    trials = sum(int(row.value or 0) for row, _ in rows)
    if rows:
        them = "it" if trials == 1 else "them"
        said = f"{count(trials, 'trial')}; shares and differences hold whatever became of {them}."
        known = known_of_broken(found, every=True)
        yield Part("Trials that broke", said, [Template("broken", {"known": known, "rows": rows})])


def _show_limits(found: Results) -> Iterator[Part]:
    """The answer says which parts of the study stand for those of the paper, which are not public."""
    answer = "Other boxes may differ." if len(found.boxes) == 1 else boxes_said(found)
    box, strategy = any(one.get("name") == "chain-4" for one in found.boxes), bool(found.reconstructed)
    if box and strategy:
        answer += " The box and the human-inspired strategy are reconstructions."
    elif box or strategy:
        answer += f" The {'box' if box else 'human-inspired strategy'} is a reconstruction."
    errors = any(row.value for row in found.where("left_out", of="ended as error"))
    values = {"caveat": LENGTHS, "errors": errors, "boxes": boxes_said(found)}
    yield Part("Limits", answer, [Template("limits", values)])


# What places give away to those who see where joints lie: people, and agents that see pictures or read places.

_MOST = 400
"""Blocks whose panels are looked at: the first of a study."""


def _places(numbers: OpenedStudy) -> Iterator[Row]:
    """How many boxes open in the fewest steps from right to left, and the steps that this takes on average."""
    study = numbers.study
    if not (PEOPLE in study.agents or any(map(shows_places, study.modalities))):
        return
    blocks = [block for _, block in zip(range(_MOST), study.blocks_of(study.agents[0]), strict=False)]
    boxes = [study.plan(study.agents[0], study.conditions[0], *block).box for block in blocks]
    steps = [steps_from_right(box, study.max_steps) for box in boxes]
    least = sum(taken == optimum(box) for box, taken in zip(boxes, steps, strict=True))
    of: dict[str, Any] = {"quantity": "optimum", "n": len(boxes)}
    yield Estimate(**of, of=f"reached {_RULE}", value=least / len(boxes), count=least)
    yield Estimate(**of, of=f"steps {_RULE}", unit="steps", value=sum(steps) / len(boxes))


_RULE = "from right to left"


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


def _show_places(found: Results) -> Iterator[Part]:
    least, steps = (found.get("optimum", of=f"{of} {_RULE}") for of in ("reached", "steps"))
    if least and steps:
        said = f"opens {percent(least.value)} of the boxes in the fewest possible steps, {steps.value:.1f} on average."
        yield Part(
            "What do places give away?",
            f"Whoever takes the joints from right to left, whatever is reported, {said}",
            ["Places are seen in this study. The agent right-to-left plays the rule, again and again."],
        )


SECTIONS = (
    Section("broken", "Trials that broke", _rows, _show),
    Section("limits", "Limits", show=_show_limits),
    Section("places", "Places", _places, _show_places),
)
