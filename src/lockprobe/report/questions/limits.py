"""What limits the numbers: trials that broke, what is known whatever became of them, and what no number shows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import median
from typing import Any

from lockprobe.foundation.formatting import count
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import Spec
from lockprobe.report.answer import BEFORE, known_of_broken
from lockprobe.report.opened import OpenedStudy, PlayedCell
from lockprobe.report.questions.boxes import boxes_said
from lockprobe.report.questions.loops import LENGTHS
from lockprobe.report.rows import PERMUTED, Estimate, Fact, Results, Row, measured_row
from lockprobe.report.section import Part, Section, Template
from lockprobe.statistics.differences import differences_before_breaks, few_broke_until
from lockprobe.statistics.every_look import E_PROCESS
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
        yield from (Fact(about=_about(agent, boundary), name=name, text=text) for name, text in facts.items())
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


def _about(agent: str, boundary: str) -> str:
    return f"{agent}, broken at {boundary}"


def _show(found: Results) -> Iterator[Part]:
    rows = [(row, found.facts_about(_about(row.agent, row.of))) for row in found.where("broken", condition="")]
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


SECTIONS = (
    Section(name="broken", title="Trials that broke", rows=_rows, show=_show),
    Section(name="limits", title="Limits", show=_show_limits),
)
