"""Why false reports change success: through what they say, or as any odd report does."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import NONE, p_cell
from lockprobe.report.captions import interval_kind
from lockprobe.report.every_look import note_at
from lockprobe.report.format import TextTable
from lockprobe.report.prose.why import ARMS, ASSUMED, why_said
from lockprobe.report.rows import Estimate, Finding, Results, Row
from lockprobe.report.section import (
    Block,
    Caption,
    Detail,
    Figure,
    Heading,
    Listed,
    Note,
    Part,
    Section,
    Table,
    Text,
)
from lockprobe.report.study_numbers import StudyNumbers, of_blocks, share_rows
from lockprobe.report.table_rows import points_cell, share_of_row
from lockprobe.statistics.sequential.contrasts import E_PROCESS
from lockprobe.statistics.why.contrasts import Why
from lockprobe.statistics.why.mechanism import CONTRASTS, PART

_EFFECT, _CONTRAST, _ARMS, _AGENTS = "false_report_effect", "arm_contrast", "arms", "agents"

_INTERVAL = "interval corrected for agents alone"

_Own = dict[str, Any]
"""The columns of one agent."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    for found in numbers.others.whys if numbers.others else ():
        own: _Own = {"agent": found.agent, "modality": found.modality}
        yield from _effects(found, own)
        yield from _arms(found, own, numbers)
        first, *others = why_said(found)
        claims = ", ".join((found.decision.verdict, *found.decision.claims))
        said = [("verdict", first), *(("numbers", one) for one in others), ("conclusion", claims)]
        for kind, text in said + [("assumption", ASSUMED)] * bool(found.decision.claims):
            yield Finding(section="why", kind=kind, **own, text=text, rests_on=(_EFFECT, "success_in_arm"))


def _test_of(found: Why) -> str:
    return E_PROCESS if found.every_look else "sign flips of blocks"


def _effects(found: Why, own: _Own) -> Iterator[Estimate]:
    """The effect of false reports, the contrasts of arms if it is detected, and what a small one is."""
    decision, doses = found.decision, {"flip.p": found.p}
    of_agent = own | {"family": _AGENTS, "corrected_for": found.agents, "doses": doses}
    tested: _Own = {"unit": "points", "test": _test_of(found)}
    yield Estimate(quantity=_EFFECT, **of_agent, of="total", **tested, **of_blocks(decision.total))
    for of, mean in decision.contrasts.items():
        yield Estimate(quantity=_CONTRAST, **of_agent, of=of, **tested, **of_blocks(mean))
    margin: dict[str, Any] = {
        "value": found.margin,
        "p_value": decision.equivalence,
        "test": f"two one-sided {'e-processes' if found.every_look else 'tests'}",
    }
    yield Estimate(quantity="equivalence_margin", **of_agent, unit="points", **margin)
    yield Estimate(quantity="blocks_needed", **own, unit="blocks", value=found.needed)


def _arms(found: Why, own: _Own, numbers: StudyNumbers) -> Iterator[Estimate]:
    """Success in every arm, and its difference from success with true reports if the total effect is detected."""
    (truth,) = (one.condition for one in found.arms if one.arm == "truth")
    for one in found.arms:
        doses = dict(numbers.study.labelled(one.condition).doses)
        arm: _Own = own | {"condition": one.condition, "of": one.arm, "doses": doses}
        yield from share_rows("success_in_arm", one.success, **arm)
        if one.change:
            tested = of_blocks(one.change) | {
                "family": _ARMS,
                "test": _test_of(found),
            }
            tested |= {"corrected_for": (len(found.arms) - 1) * found.agents, "note": _INTERVAL}
            yield Estimate(quantity="success_difference", **arm, control=truth, unit="points", **tested)


def _asked(found: Results) -> list[Estimate]:
    """The total effect on every agent."""
    return found.where(_EFFECT, of="total")


def _arms_compared(of: str) -> str:
    """The arms that give a contrast."""
    pairs = [f"{more} \N{MINUS SIGN} {less}" for more, less in {"total": (("lie", "truth"),), **CONTRASTS}[of]]
    return pairs[0] if len(pairs) == 1 else f"half of ({pairs[0]}) + ({pairs[1]})"


def _table(found: Results) -> TextTable:
    """The effect of false reports, and the contrasts of arms where it is detected."""
    head = ["agent", "estimand", "arms", "estimate, points", "P", "blocks"]
    table = [head]
    for total in _asked(found):
        contrasts = found.where(_CONTRAST, agent=total.agent, modality=total.modality)
        for row in (total, *contrasts):
            size = [points_cell(row), p_cell(row.p_value), str(row.clusters)]
            table.append([row.agent, "total effect" if row is total else row.of, _arms_compared(row.of), *size])
    return table if len(table) > 1 else []


def _arm_table(found: Results) -> TextTable:
    """Success in every arm, and its difference from true reports."""
    head = ["agent", "arm", "at the selected steps", "solved", "success", "difference from truth, points", "P"]
    table = [head]
    for row in found.where("success_in_arm"):
        own = {"agent": row.agent, "modality": row.modality, "condition": row.condition}
        change = found.get("success_difference", **own, of=row.of, family=_ARMS)
        size = [points_cell(change), p_cell(change.p_value)] if change else [NONE, NONE]
        table.append([row.agent, row.of, ARMS[row.of], f"{row.count}/{row.n}", share_of_row(row), *size])
    return table if len(table) > 1 else []


_WHY = Table("why", _table, numeric_from=3)
_ARM = Table("arms", _arm_table, numeric_from=3)


def _caption(found: Results) -> Caption:
    return Caption(
        "Share of trials solved. Squares: reports in two statements, by what the first says and by what its correction "
        "says. Left: plain reports, true or false, and true reports with an irrelevant remark.",
        f"Brackets are 95 % {interval_kind(found.progress.every_look)}. The other panels: the total effect of false "
        "reports (filled) and, if it was detected, differences between arms (hollow), in matched pairs with 95 % "
        "intervals corrected for the number of agents.",
    )


_FIGURE = Figure(
    "why",
    "Success by first and last statement of a report, and with true reports, false reports and a remark",
    _caption,
    draw="lockprobe.report.figures.why:why",
    applies=lambda found: bool(_asked(found)),
)


def _show(found: Results) -> Iterator[Part]:
    """What was found of every agent, then its numbers, all arms and the limits."""
    if asked := _asked(found):
        many = max(row.corrected_for for row in asked) > 1
        verdicts = [_verdict(found, row) for row in asked]
        assumed = [Text(said, style="note") for said in dict.fromkeys(found.said("why", "assumption"))]
        yield Part("Why?", verdicts[0] if len(verdicts) == 1 else "", [Listed(verdicts), *assumed], "why")
        yield _numbers(found, asked, many)
        said = f"Success in {len({row.of for row in found.where('success_in_arm')})} arms with common random numbers."
        margin = found.where("equivalence_margin")[0].value or 0.0
        limits = Detail("What these comparisons do not show", [Listed(_limits(margin))])
        yield Part("Arms", said, [_ARM, _arm_note(many, interval_kind(found.progress.every_look)), limits], "arms")


def _verdict(found: Results, row: Estimate) -> str:
    return found.said("why", "verdict", agent=row.agent, modality=row.modality)[0]


def _numbers(found: Results, asked: Sequence[Estimate], many: bool) -> Part:
    many_agents = f" on {len(asked)} agents" if len(asked) > 1 else ""
    answer = f"The effect of false reports{many_agents}, and the differences between arms."
    blocks: list[Block] = []
    for row in asked:
        own = found.said("why", "numbers", agent=row.agent, modality=row.modality)
        blocks += [Heading(row.agent, code=True), *map(Text, own)]
    return Part("Numbers", answer, [*blocks, _WHY, note_at(found, _note(many))], "parts")


def _note(many: bool) -> Note:
    return Note(
        Markup(
            "Effect of false reports on success, and differences between arms, in points. The comparison of "
            "<code>lie</code> with <code>truth</code> is planned and not corrected{}; in the table of arms it is "
            "corrected for the number of arms, so its <i>P</i> is larger."
        ).format(" for arms" if many else ""),
        Markup(
            "Each estimate is a mean of differences within blocks, with Student\N{RIGHT SINGLE QUOTATION MARK}s 95 % "
            "interval over blocks. <i>P</i> is that of a sign-flip permutation test over blocks{}."
        ).format("; both are corrected for the number of agents, baselines apart" if many else ""),
        Markup(
            "Every arm intervenes at the same steps of the same trials: one random number per step decides for all "
            "arms. A block is one repetition and trial in all arms, with common random numbers. Intervals are widened "
            "as if one more pair differed (Agresti and Min). The total effect is detected if <i>P</i> is below 0.05 "
            "and the interval excludes 0. Only then does this page compare other arms; a difference is detected if "
            "<i>P</i> is below {} and the interval excludes 0{}. A claim needs all of its differences, so that several "
            "claims need no correction."
        ).format(PART, "; both levels are divided by the number of agents" if many else ""),
    )


def _arm_note(many: bool, kind: str) -> Note:
    corrected = (
        Markup("both are corrected for the number of agents, and <i>P</i> also")
        if many
        else Markup("intervals are not corrected, and <i>P</i> is corrected")
    )
    return Note(
        "Success in every arm, and its difference from the arm with true reports.",
        Markup(
            "Success has 95 % {}. Differences are between matched pairs of trials; {} for the number of arms (Holm)."
        ).format(kind, corrected),
    )


def _limits(margin: float) -> list[str]:
    return [
        Markup(
            "The crossing shows how reports in two statements act. That a plain false report acts as they do is "
            "assumed. An agent may trust less what was corrected; <code>truth-truth</code> against <code>truth</code> "
            "shows what a correction does by its form."
        ),
        (
            "In simulated worlds in which plain reports act as reports in two statements do, the first part of the "
            "sentence was wrong in at most 5 % of studies. An agent that any odd form changes, and a plain false "
            "report by what it says, is said to react as to any odd report."
        ),
        (
            "The clause after the first part describes the arms; it is no proof of what the agent does within. Later "
            "reports of a joint build on the last statement: a reader of first statements who compares positions meets "
            "a contradiction after truth-lie too, and looks like one for whom a single false statement is enough."
        ),
        (
            "Where no effect is detected, a test asks whether changes of "
            f"{100 * margin:.0f} points or more can be excluded. This margin was chosen by judgement."
        ),
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
    ),
)
