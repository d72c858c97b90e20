"""Why false reports change success: their content, or the disturbance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from markupsafe import Markup

from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.why import Why
from lockprobe.formatting import p_cell
from lockprobe.prose.why import ARMS, why_said
from lockprobe.record import Trial
from lockprobe.report.examples import exhibit
from lockprobe.report.format import TextTable
from lockprobe.report.section import Block, Caption, Figure, Heading, Listed, Note, Part, Section, Steps, Table, Text
from lockprobe.report.sections import forks
from lockprobe.report.sections.effects import of_blocks
from lockprobe.report.study_numbers import StudyNumbers, share_rows
from lockprobe.report.table_rows import points_cell, share_of_row
from lockprobe.rows import Estimate, Exhibit, Finding, Results, Row

__all__ = ["SECTIONS"]

_EFFECT, _ARMS, _AGENTS = "false_report_effect", "arms", "agents"

_INTERVAL = "interval corrected for agents alone"

_Own = dict[str, Any]
"""The columns of one agent."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    for found in numbers.others.whys if numbers.others else ():
        own: _Own = {"agent": found.agent, "modality": found.modality}
        yield from _effects(found, own)
        yield from _arms(found, own, numbers)
        first, *others = why_said(found)
        for kind, said in (("verdict", first), *(("numbers", one) for one in others), ("conclusion", found.verdict)):
            yield Finding(section="why", kind=kind, **own, text=said, rests_on=(_EFFECT, "success_difference"))
        yield from _told_twice(found, numbers.trials)


def _effects(found: Why, own: _Own) -> Iterator[Estimate]:
    """The effect of false reports, its parts, and what a small one is."""
    of_agent = own | {"family": _AGENTS, "corrected_for": found.agents, "doses": {"flip.p": found.p}}
    parts: dict[str, BlockMean | None] = {
        "total": found.change,
        "content": found.says,
        "disturbance": found.disturbs,
        "falsity": found.falsity,
        "remark": found.disturbance,
        "falsity by remark": found.interaction,
        "timing in loops": found.contingent,
    }
    for of, mean in parts.items():
        if mean is not None:
            tested = of_blocks(mean) | {"test": "sign flips of blocks"}
            yield Estimate(quantity=_EFFECT, **of_agent, of=of, unit="points", **tested)
    margin: dict[str, Any] = {"value": found.margin, "p_value": found.equivalence, "test": "two one-sided tests"}
    yield Estimate(quantity="equivalence_margin", **of_agent, unit="points", **margin)
    yield Estimate(quantity="blocks_needed", **own, unit="blocks", value=found.needed)


def _arms(found: Why, own: _Own, numbers: StudyNumbers) -> Iterator[Estimate]:
    """Success in every arm, and its difference from success with true reports."""
    (truth,) = (one.condition for one in found.arms if one.arm == "truth")
    for one in found.arms:
        doses = dict(numbers.study.labelled(one.condition).doses)
        arm: _Own = own | {"condition": one.condition, "of": one.arm, "doses": doses}
        yield from share_rows("success_in_arm", one.success, **arm)
        if one.change:
            tested = of_blocks(one.change) | {"family": _ARMS, "test": "sign flips of blocks"}
            tested |= {"corrected_for": (len(found.arms) - 1) * found.agents, "note": _INTERVAL}
            yield Estimate(quantity="success_difference", **arm, control=truth, unit="points", **tested)


def _told_twice(found: Why, trials: Sequence[Trial]) -> Iterator[Exhibit]:
    """The first trial of an agent that it solved under true reports or under false ones, but not under both."""
    names = {one.arm: one.condition for one in found.arms}
    own = {(one.condition, one.repetition, one.trial): one for one in trials if one.group == found.agent}
    for (condition, repetition, number), truth in own.items():
        lie = own.get((names["lie"], repetition, number))
        if condition != names["truth"] or lie is None or "error" in (truth.ending, lie.ending):
            continue
        if truth.solved != lie.solved:
            same = [a == b for a, b in zip(truth.actions, lie.actions, strict=False)]
            parted = (same.index(False) if False in same else len(same)) + 1
            yield exhibit("why", "Under true reports", truth, of="truth", parted=parted)
            yield exhibit("why", "Under false reports", lie, of="lie", parted=parted)
            return


def _asked(found: Results) -> list[Estimate]:
    """The total effect on every agent."""
    return found.where(_EFFECT, of="total")


_ESTIMANDS = {
    "total": ("total effect", "lie - truth"),
    "content": ("content (debunking effect)", "lie - retracted"),
    "disturbance": ("disturbance", "retracted - truth"),
    "falsity": ("falsity, mean effect", "half of (lie - truth) + (lie + remark - remark)"),
    "remark": ("remark, mean effect", "half of (remark - truth) + (lie + remark - lie)"),
    "falsity by remark": ("falsity by remark, interaction", "(lie + remark - remark) - (lie - truth)"),
    "timing in loops": ("timing in loops", "lie in loops - self-yoked"),
}
"""Part of the effect -> its name, and the arms that give it."""


def _table(found: Results) -> TextTable:
    """The effect of false reports and its parts."""
    head = ["agent", "estimand", "arms", "estimate, points", "P", "blocks"]
    rows = [
        [row.agent, *_ESTIMANDS[row.of], points_cell(row), p_cell(row.p_value), str(row.clusters)]
        for row in found.where(_EFFECT)
    ]
    return [head, *rows] if rows else []


def _arm_table(found: Results) -> TextTable:
    """Success in every arm, and its difference from true reports."""
    head = ["agent", "arm", "at the selected steps", "solved", "success", "difference from truth, points", "P"]
    table = [head]
    for row in found.where("success_in_arm"):
        own = {"agent": row.agent, "modality": row.modality, "condition": row.condition}
        change = found.get("success_difference", **own, of=row.of, family=_ARMS)
        size = [points_cell(change), p_cell(change.p_value if change else None)]
        table.append([row.agent, row.of, ARMS[row.of], f"{row.count}/{row.n}", share_of_row(row), *size])
    return table if len(table) > 1 else []


_WHY = Table("why", _table, numeric_from=3, cards=True)
_ARM = Table("arms", _arm_table, numeric_from=3, cards=True)

_FIGURE = Figure(
    "why",
    "Success in every arm, and the effects of false reports by content and by disturbance",
    Caption(
        "Top: share of trials solved in each arm; the dotted line is the share with true reports. Bottom: the effect "
        "of false reports and its two parts, content and disturbance.",
        "Intervals are 95 %: Wilson intervals at the top; at the bottom over matched pairs of trials, corrected for "
        "the number of agents.",
    ),
    draw="lockprobe.figures.why:why",
    applies=lambda found: bool(_asked(found)),
)


def _show(found: Results) -> Iterator[Part]:
    """The parts of the page; its template has the verdicts above the first."""
    if asked := _asked(found):
        many = max(row.corrected_for for row in asked) > 1
        yield Part("", "", [_FIGURE], "top")
        yield _numbers(found, asked, many)
        yield _by_step(found)
        yield _twice(found, asked)
        said = f"Success in {len(_arm_table(found)) - 1} arms with common random numbers."
        yield Part("Arms", said, [_ARM, _arm_note(many)], "arms")
        margin = found.where("equivalence_margin")[0].value or 0.0
        yield Part("Limits", "What these comparisons do not show.", [Listed(_limits(margin))], "limits")


def _numbers(found: Results, asked: Sequence[Estimate], many: bool) -> Part:
    said = found.said("why", "numbers")
    answer = f"The effect of false reports and its two parts, for {len(asked)} agents."
    blocks: list[Block] = []
    for row in asked:
        own = found.said("why", "numbers", agent=row.agent, modality=row.modality)
        blocks += [Heading(row.agent, code=True), *map(Text, own)]
    return Part("Numbers", said[0] if len(asked) == 1 and said else answer, [*blocks, _WHY, _note(many)], "parts")


def _note(many: bool) -> Note:
    return Note(
        Markup(
            "Effect of false reports on success and its parts, in points. The comparison of <code>lie</code> with "
            "<code>truth</code> is planned and not corrected{}; in the table of arms it is corrected for the number of "
            "arms, so its <i>P</i> is larger."
        ).format(" for arms" if many else ""),
        Markup(
            "Each estimate is a mean of differences within blocks, with Student\N{RIGHT SINGLE QUOTATION MARK}s 95 % "
            "interval over blocks. <i>P</i> is that of a sign-flip permutation test over blocks{}."
        ).format("; both are corrected for the number of agents, baselines apart" if many else ""),
        Markup(
            "Every arm intervenes at the same steps of the same trials: one random number per step decides for all "
            "arms. A block is one repetition and trial in all arms, with common random numbers. Intervals are widened "
            "as if one more pair differed (Agresti and Min). An effect is detected if <i>P</i> is below 0.05 and the "
            "interval excludes 0. The two parts are tested only if the whole effect is detected, each at 5 %{}: they "
            "add up to the whole, so at most one of them is zero, and the verdict is wrong in at most 5 % of studies."
        ).format(" divided by the number of agents" if many else ""),
    )


def _by_step(found: Results) -> Part:
    if said := found.said("forks", "finding"):
        more = Markup(
            'Trials are forked at one report, which is changed. <a href="forks.html">Numbers, method and limits</a>'
        )
        return Part("The effect by step", said[0], [forks.FIGURE, Text(more, style="note")], "steps")
    how = Markup(
        "<code>lockprobe branch DIR</code> forks these trials after single reports and shows the effect of a false "
        "report by step."
    )
    return Part("The effect by step", "Not measured in this study.", [Text(how, style="note")], "steps")


def _twice(found: Results, asked: Sequence[Estimate]) -> Part:
    shown = [one for one in found.exhibits if one.section == "why"]
    told = [one for one in shown if one.of == "truth"]
    note = Note(
        "One trial with true and with false reports and the same random numbers: the first on record that was solved "
        "with only one of them, not a typical one. A blue frame marks the first step at which the actions differ.",
        "Each panel is a step: squares are joints in panel order, grey if they have moved; the circle is the target; a "
        "frame marks the attempt. The report is below, in red if it was false.",
    )
    answer = f"An example for each of {len(told)} agents." if told else ""
    if len(told) == 1:
        answer = f"The actions differ from step {told[0].parted} on."
    blocks: list[Block] = [note]
    for one in shown:
        blocks += [Heading(one.agent, code=True)] if one.of == "truth" else []
        blocks.append(Steps(one, strip=True))
    return Part("One trial with true and with false reports", answer, blocks, "twice")


def _arm_note(many: bool) -> Note:
    corrected = (
        Markup("both are corrected for the number of agents, and <i>P</i> also")
        if many
        else Markup("intervals are not corrected, and <i>P</i> is corrected")
    )
    return Note(
        "Success in every arm, and its difference from the arm with true reports.",
        Markup(
            "Success has 95 % Wilson intervals. Differences are between matched pairs of trials; {} for the number of "
            "arms (Holm)."
        ).format(corrected),
    )


def _limits(margin: float) -> list[str]:
    return [
        Markup(
            "The analysis assumes that a corrected false report disturbs as much as an uncorrected one. A correction "
            "may itself lower trust in reports: the arm <code>confirmed</code> corrects true reports and shows the "
            "effect of a correction alone."
        ),
        f"Changes of less than {100 * margin:.0f} points count as no change. This margin was chosen by judgement.",
        (
            "A trial that is solved early has fewer interventions. After actions differ, arms intervene in different "
            "situations; so whole trials are compared, not steps."
        ),
        (
            "An agent whose sampling cannot be seeded shares only the steps of the interventions between arms. Its "
            "differences vary more and need more blocks."
        ),
    ]


SECTIONS = (
    Section(
        name="why",
        title="Why false reports change success",
        rows=_rows,
        show=_show,
        tables=(_WHY, _ARM),
        figures=(_FIGURE,),
        page="why",
    ),
)
