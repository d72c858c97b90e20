"""Trials that broke: how many at which boundary, what is known of success whatever became of them, and by when."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import median
from typing import Any

from lockprobe.foundation.formatting import capital, change, count, p_value, percent
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import Spec
from lockprobe.report.prose.doses import at_dose
from lockprobe.report.prose.success import broke_said
from lockprobe.report.rows import Estimate, Fact, Finding, Results, Row
from lockprobe.report.section import Part, Section, Template
from lockprobe.report.study_numbers import PlayedCell, StudyNumbers
from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.statistics.inference.before_breaks import FEW, differences_before_breaks, few_broke_until
from lockprobe.statistics.outcomes import broken_off, outcomes
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.sequential.contrasts import E_PROCESS
from lockprobe.statistics.sequential.order import BlockOrder
from lockprobe.trial.record import Trial

BEFORE = "by the last step with few breaks"
"""Part of success: by the last step by which at most 5 % of trials broke under every condition."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    """By agent and boundary, with the first message, and whether the first of them will be replayed."""
    broken: dict[tuple[str, str], list[Trial]] = {}
    for trial in numbers.opened.trials:
        if trial.error is not None:
            broken.setdefault((trial.group, str(trial.error.boundary)), []).append(trial)
    for (agent, boundary), trials in sorted(broken.items()):
        yield Estimate(quantity="broken", agent=agent, of=boundary, value=len(trials), unit="trials")
        first = trials[0]
        about = _about(agent, boundary)
        yield Fact(about=about, name="first message", text=_message(first))
        yield Fact(about=about, name="will be replayed", text="yes" if first.owed_again else "no")
    of_agents = grouped(numbers.cells, lambda cell: (cell.agent, cell.modality)).values()
    broke = [cells for cells in of_agents if any(cell.summary.errors for cell in cells)]
    for cells in broke:
        yield from _of_agent(cells, numbers, len(broke))


def _of_agent(cells: Sequence[PlayedCell], numbers: StudyNumbers, agents: int) -> Iterator[Row]:
    """Whether the trials of an agent broke because they are long, and what is known of them, in all and earlier."""
    of: dict[str, Any] = {"agent": cells[0].agent, "modality": cells[0].modality}
    trials = [trial for cell in cells for trial in cell.trials]
    ends = {
        "broken": [len(trial.steps) + 1 for trial in trials if trial.error is not None],
        "ended": [len(trial.steps) for trial in trials if trial.error is None],
    }
    for part, steps in ends.items():
        if steps:
            yield Estimate(quantity="median_end", **of, of=part, unit="steps", value=median(steps), n=len(steps))
    for i, cell in enumerate(cell for cell in cells if cell.summary.success.broken):
        said = f"{capital(_where(cell))}: {broke_said(cell.summary.success)}"
        kind = "known elsewhere" if i else "known"
        yield Finding(section="broken", kind=kind, **of, text=said, rests_on=("success", "broken"))
    if ends["ended"] and (late := median(ends["broken"])) > (usual := median(ends["ended"])):
        said = f"half of the breaks came at step {late:g} or later, other trials ended at step {usual:g}"
        text = f"What is missing is long: {said}."
        yield Finding(section="broken", kind="long", **of, text=text, rests_on=("median_end",))
    order = numbers.opened.orders.get(cells[0].agent)
    yield from _earlier([cell for cell in cells if cell.summary.success.n], of, agents, order)


def _earlier(
    cells: Sequence[PlayedCell], of: dict[str, Any], agents: int, order: BlockOrder | None
) -> Iterator[Estimate | Finding]:
    """Every condition against the first, by the last step by which few trials of each broke.

    At every look this step can be another one. What is said then allows for all steps of the budget.
    """
    counted, broken = ([made(cell.trials, order=order) for cell in cells] for made in (outcomes, broken_off))
    budget = max((trial.budget for cell in cells for trial in cell.trials), default=0)
    step, many = few_broke_until(counted, broken, budget), agents if order is None else agents * budget
    yield Estimate(quantity="few_broke_until", **of, unit="steps", value=step)
    if len(cells) < 2 or not 0 < step < budget:
        return
    first = cells[0].trials[0]
    rng = generator(first.seed, "analysis", first.spec, first.modality, BEFORE)
    found = differences_before_breaks(counted, broken, step, rng, agents=many)
    test = "McNemar, and interval" if order is None else E_PROCESS
    for place, one in found:
        yield Estimate(
            quantity="success_difference",
            **cells[place].of,
            control=cells[0].condition,
            of=BEFORE,
            unit="points",
            n=one.first.n,
            value=one.value,
            low=one.low,
            high=one.high,
            p_value=one.p_value,
            family=f"success {BEFORE}",
            corrected_for=len(found) * many,
            test=test if one.pairs else "permutation within blocks, and interval",
        )
    if not found:
        return
    place, one = min(found, key=lambda pair: (pair[1].p_value, -abs(pair[1].value)))
    known = "" if one.p_value < ALPHA else " This does not show that there is no effect."
    looks = f", corrected for {len(found) * many} comparisons" if len(found) * many > 1 else ""
    yield Finding(
        section="broken",
        kind="earlier",
        **of,
        text=f"By step {step} at most {percent(FEW)} of trials had broken under every condition. By then "
        f"{percent(one.second.value)} were solved {_where(cells[place])} and {percent(one.first.value)} "
        f"{_where(cells[0])} ({change(one.value, one.low, one.high)}; {p_value(one.p_value)}{looks}).{known}",
        rests_on=("success_difference", "few_broke_until"),
    )


def _where(cell: PlayedCell) -> str:
    return at_dose(cell.summary.dose, FLIPS) if cell.player else f"under {cell.condition}"


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
        of_agents = grouped(
            (one for one in found.findings if one.section == "broken"),
            lambda one: found.label(one.agent, one.modality),
        )
        known = [(label, " ".join(one.text for one in own)) for label, own in of_agents.items()]
        yield Part(
            "Trials that broke", said, [Template("of_agents", {"said": known}), Template("broken", {"rows": rows})]
        )


SECTIONS = (Section(name="broken", title="Trials that broke", rows=_rows, show=_show),)
