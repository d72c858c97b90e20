"""The paper's claims: each beside what the study measured of it, with a verdict, from the rows of all questions.

``paper_claims.toml`` has the claims, with what judges each of them. A verdict has two parts: whether a valid test shows
the pattern of the claim (1), its opposite (-1) or neither (0), and whether a test tells its figure from the paper's. A
claim about all three modalities can be contradicted by an agent that was not shown the box in all of them, and not
borne out.
"""

from __future__ import annotations

import math
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib.resources import files
from typing import Any, Literal, NamedTuple

from lockprobe.foundation.formatting import p_cell, percent
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import spec_kind, spec_name
from lockprobe.report.format import entry_text
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import false_reports
from lockprobe.report.rows import RECONSTRUCTED, Cell, Course, Fact, Results, clearness
from lockprobe.report.section import Block, Lines, Note, Part, Section, Table
from lockprobe.statistics import published
from lockprobe.statistics.blocks import FEWEST
from lockprobe.statistics.distributions import welch_test
from lockprobe.statistics.modalities import by_fidelity, spoken
from lockprobe.statistics.multiple_testing import holm
from lockprobe.statistics.proportions import ALPHA, Proportion, difference, proportion
from lockprobe.trial.record import PLAIN_WORDS

_NEAR = 0.1
"""How far a peak "near 40 %" may lie from it: the next flip rate of the paper."""

_OF_MODALITIES, _OVER_RATES = ("modalities", "order", "paces", "strategy"), ("change", "effect", "row")
"""Judges of claims about several modalities, and of what changes over flip rates, for which an agent heeds reports."""

_FOUND = ("neither it nor its opposite was detected", "it was detected", "its opposite was detected")
"""By the sign of a pattern."""


class PaperClaim(NamedTuple):
    """A claim as ``paper_claims.toml`` has it, which says what each of these is."""

    measure: str
    place: str
    quote: str
    value: str = ""
    recomputed: str = ""
    modality: str = "symbolic"
    of: Literal["agents", "strategy"] = "agents"
    judge: str = ""
    quantity: str = ""
    part: str = ""
    paper: Sequence[int] = ()
    way: int = 0
    signs: Mapping[str, int] = {}
    size: Literal["", "difference", "ratio", "correlation"] = ""
    pairs: Sequence[Sequence[str]] = ()
    steps: Mapping[str, int] = {}


class Judged(NamedTuple):
    """What was measured of a claim, the verdict, what it rests on, and the P value of the test that this begins with.

    ``agent`` is what tables call who was measured. By default nothing was.
    """

    here: str = ""
    verdict: str = "not measured"
    test: str = ""
    p_value: float | None = None
    agent: str = ""


@cache
def paper_claims() -> tuple[PaperClaim, ...]:
    """The claims, in the order of the paper."""
    text = files("lockprobe.report").joinpath("paper_claims.toml").read_text("utf-8")
    return tuple(PaperClaim(**one) for one in tomllib.loads(text)["claim"])


def _sign(p: float | None, direction: float) -> int:
    """From a two-sided test, where a positive direction is that of the claim."""
    return 0 if p is None or p >= ALPHA or not direction else 1 if direction > 0 else -1


def _judged(here: str, sign: int, test: str, p: float | None = None, *, figure: bool = False) -> Judged:
    """The verdict from the sign of a pattern; of a ``figure`` the test may tell it from the paper's too."""
    sign = -1 if figure and p is not None and p < ALPHA else sign
    verdicts = "not compatible", "not decided", "compatible" if figure else "borne out"
    return Judged(here, verdicts[sign + 1], test, p)


def _share_of(cell: Cell, quantity: str) -> Proportion:
    row, broken = cell.found.one(quantity, **cell.own), int(cell.value("broken") or 0) * (quantity == "success")
    low, high = row.low or 0.0, 1.0 if row.high is None else row.high
    return replace(proportion(row.count or 0, row.n or 0), low=low, high=high, broken=broken)


def _shown(one: Proportion) -> str:
    return f"{one.count}/{one.n}, {one.value:.3f} [{one.low:.3f}, {one.high:.3f}]"


def _beyond(first: Cell, others: Sequence[Cell], claim: PaperClaim, way: int) -> bool:
    """Whether one of them is shown to lie beyond the first in a direction, corrected for their number (Holm)."""
    changes = [difference(_share_of(first, claim.quantity), _share_of(one, claim.quantity)) for one in others]
    corrected = holm([one.p_value if one else None for one in changes])
    return any(_sign(p, way * one.value) > 0 for p, one in zip(corrected, changes, strict=True) if one)


def _peak_of(course: Course) -> Cell | None:
    """What it did at the flip rate at which the paper has its peak."""
    return next((cell for cell in course.played if math.isclose(cell.dose or 0.0, published.PEAK)), None)


def _moved(course: Course, claim: PaperClaim) -> int:
    """Whether a share moves in the direction of the claim from 0 to the paper's peak."""
    if (peak := _peak_of(course)) is None:
        return 0
    change: Any = difference(_share_of(course.played[0], claim.quantity), _share_of(peak, claim.quantity))
    if claim.quantity == "success":  # in pairs, as the page has it
        change = next((row for cell, row in course.changes() if cell == peak), None)
    return _sign(change.p_value, claim.way * (change.value or 0.0)) if change else 0


def _step_of(cell: Cell, paper: int) -> tuple[str, int]:
    """The step by which 80 % of the trials are solved, and whether its interval holds the paper's."""
    row = cell.get("steps_to_solve", "80 %")
    step, early, late = (row.value, row.low, row.high) if row else (None, None, None)
    said, *ends = ("not reached" if one is None else f"{one:g}" for one in (step, early, late))
    inside = (early or math.inf) <= paper <= (late or math.inf)
    return f"80 % by step {said} [{', '.join(ends)}]", 1 if inside else -1


def _told_the_truth(course: Course, claim: PaperClaim) -> Judged | None:
    """What one agent says to a claim by what it did at a flip rate of 0; None if nothing."""
    first = course.played[0]
    match claim.judge:
        case "share":  # at 0 it is the paper's; with a way it moves so up to the paper's peak
            here, paper = _share_of(first, claim.quantity), proportion(*claim.paper)
            found, test, sign = difference(paper, here), f"Fisher, against {paper.count}/{paper.n}", 1
            if claim.way:
                back = _beyond(first, course.played[1:], claim, -claim.way)
                sign = 0 if course.blind else -1 if back else _moved(course, claim)
                test += f"; of a change up to 0.4 {_FOUND[sign]}"
            return _judged(_shown(here), sign, test, found.p_value if found else None, figure=True)
        case "step":
            said, sign = _step_of(first, claim.paper[0])
            return _judged(said, sign, "95 % interval of the step, from the band", figure=True)
        case "misread":  # as often as in the paper
            rate, spread, total = (first.get("misinterpretations", of) for of in ("rate", "SD of rates", ""))
            if rate and spread and total and rate.value is not None and spread.value is not None:
                rates = rate.value, spread.value, rate.n or 0
                p = welch_test(published.TABLE1[spec_name(course.modality)], rates)
                said = f"{percent(rate.value, 1)} ± {percent(spread.value, 1)}, {total.value:g} in all"
                return _judged(said, 1, "Welch, on the rates per trial", p, figure=True)
        case "half" if (row := first.get(claim.quantity, claim.part)) and None not in (row.low, row.high):
            sign = 1 if (row.low or 0.0) > 0.5 else -1 if (row.high or 0.0) < 0.5 else 0
            said = f"{row.count} of {row.n}, {entry_text(row)}"
            return _judged(said, sign, "95 % interval above or below one half")
    return None


def _over_rates(course: Course, claim: PaperClaim) -> Judged | None:
    """What one agent that heeds reports says to a claim by what changes over the flip rates; None if nothing."""
    first, peak = course.played[0], _peak_of(course)
    match claim.judge:
        case "change" if peak:  # from 0 to the paper's peak, nowhere further, and by as much as in the paper
            one, two = (_share_of(cell, claim.quantity) for cell in (first, peak))
            near = 0.0 if claim.quantity == "success" else _NEAR
            far = [cell for cell in course.played if abs((cell.dose or 0.0) - published.PEAK) > near + 1e-9]
            sign = -1 if _beyond(peak, far, claim, claim.way) else _moved(course, claim)
            said, test, p = f"{one.count}/{one.n} at 0, {two.count}/{two.n} at 0.4", _FOUND[sign], None
            if claim.size in ("difference", "ratio"):
                paper_shares = published.SOLVED if claim.quantity == "success" else published.LOOPED
                p = published.change_p(claim.size, (one, two), paper_shares)
                test = f"z test of the {claim.size}, against the paper's; of the change {test}"
            return _judged(said, sign, test, p, figure=True)
        case "effect" if changes := course.changes():  # above that at 0 for some rate; the opposite is a fall at 0.4
            rises = [(cell, of) for cell, of in changes if _sign(of.p_value, of.value or 0.0) > 0]
            at_peak = [(cell, of) for cell, of in changes if cell == peak]
            largest = max(changes, key=lambda one: one[1].value or 0.0)
            cell, change = min(rises, key=lambda one: clearness(one[1])) if rises else (at_peak or [largest])[0]
            sign = _sign(change.p_value, change.value or 0.0) if rises or at_peak else 0
            said = f"{entry_text(change)} points from 0 to {cell.dose:g}"
            return _judged(said, sign, "permutation test, corrected for all flip rates", change.p_value)
        case "row" if (row := course.get(claim.quantity, claim.part)) and row.p_value is not None:
            # a number over all flip rates shows the pattern by its sign or its note; a correlation is the paper's
            sign = _sign(row.p_value, claim.way * (row.value or 0.0) if claim.way else claim.signs.get(row.note, 0))
            said = f"{claim.quantity.replace('_', ' ')} {entry_text(row)}{f', {row.note}' * bool(row.note)}"
            if claim.size != "correlation":
                return _judged(said, sign, f"{row.test}; {_FOUND[sign]}", row.p_value)
            if row.n is not None and row.value is not None and row.n >= 4 and abs(row.value) != 1:
                test = f"Fisher's z test, over {row.n} points; {_FOUND[sign]}"
                return _judged(said, sign, test, published.correlation_p(row.value, row.n), figure=True)
    return None


def _sooner(found: Results, agent: str, pair: Sequence[str], names: Mapping[str, str]) -> tuple[int, float | None, str]:
    """Whether the box is opened sooner with the first of two modalities, its P value, and the ratio of hazards."""
    for row in found.where("hazard_ratio", agent=agent, of="modalities"):
        kinds = spec_name(row.versus_modality), spec_name(row.modality)
        asked = (row.versus_modality, row.modality) == tuple(names[one] for one in pair)
        if asked or kinds == (*pair,) == ("rgb", "rgbd"):
            said = f"{entry_text(row)} ({spoken(row.modality)} over {spoken(row.versus_modality)})"
            return _sign(row.p_value, 1 - (row.value or 1.0)), row.p_value, said
    return 0, None, ""


def _of_modalities(found: Results, agent: str, by: Mapping[str, Cell], claim: PaperClaim) -> Judged | None:
    """What one agent that is told the truth says to a claim about modalities (Sec. 3.1), from low to high fidelity.

    The paper's ground truth is a state; reports that tell outcomes too stand for it if alone. Only all three can show
    what is said of three.
    """
    names = {"rgb": "rgb", "rgbd": "rgbd", "symbolic": next((one for one in PLAIN_WORDS if one in by), "symbolic")}
    three, pairs = {*names.values()} <= by.keys(), [_sooner(found, agent, pair, names) for pair in claim.pairs]
    signs, trend = [sign for sign, *_ in pairs], found.one("modality_effect", agent=agent, of="trend over fidelity")
    match claim.judge:
        case "modalities":  # as many trials are solved as in the paper, in every modality
            paper, shares = proportion(*claim.paper), {name: _share_of(cell, "success") for name, cell in by.items()}
            tested = [one.p_value for share in shares.values() if (one := difference(paper, share))]
            p = min((p for p in holm(tested) if p is not None), default=None)
            here = "; ".join(f"{_shown(share)} with {spoken(modality)}" for modality, share in shares.items())
            test = f"Fisher, against {paper.count}/{paper.n} in each modality, corrected for their number"
            return _judged(here, int(three), test, p, figure=True)
        case "order" if trend.p_value is not None:  # sooner the lower the fidelity is; no two neighbours contradict it
            means = ", ".join(f"{cell.value('mean_steps_all'):.1f} with {spoken(name)}" for name, cell in by.items())
            sign = -1 if -1 in signs else _sign(trend.p_value, -(trend.value or 0.0))
            test = "log-rank test for a trend over fidelity"
            return _judged(f"mean steps {means}", min(sign, int(three)), test, trend.p_value)
        case "paces":  # sooner in the first modality of each pair; with steps 80 % by the paper's steps
            steps = [_step_of(by[at], n) for name, n in claim.steps.items() if (at := names[name]) in by]
            if ratios := [ratio for *_, ratio in pairs if ratio]:
                steps.append((f"hazard ratio of solving {', '.join(ratios)}", 1))
            if steps:
                sign = -1 if any(inside < 0 for _, inside in steps) else min(signs)
                sign = sign if claim.measure == "depth" else min(sign, int(three))
                p = max((one for _, one, _ in pairs if one is not None), default=None)
                here, test = "; ".join(one for one, _ in steps), "log-rank, corrected for the pairs"
                return _judged(here, sign, test, figure=bool(claim.steps))._replace(p_value=p)
        case "strategy" if not found.several_p:  # the human-inspired strategy needs fewer steps in every modality
            rows = [
                row
                for row in found.where("steps_difference", agent=agent, axis="flip rate")
                if row.versus in found.reconstructed and row.versus_modality in PLAIN_WORDS and row.modality in by
            ]
            if rows:
                signs = [_sign(row.p_value, row.value or 0.0) for row in rows]
                sign = -1 if -1 in signs else int(three and len(rows) == len(by) and min(signs) > 0)
                here = "; ".join(f"{entry_text(row)} steps more with {spoken(row.modality)}" for row in rows)
                p = max((row.p_value for row in rows if row.p_value is not None), default=None)
                return _judged(here, sign, f"{rows[0].test}; the largest P value", p)
    return None


def judged(found: Results, claim: PaperClaim) -> Iterator[Judged]:
    """What every agent that speaks to a claim says to it; of other readings of a false report only what differs."""
    said = dict[Judged, Judged]()
    for axis in (None, *(one for one in found.design.axes if one.axis.of_flips and one.players)):
        reading = f", {false_reports(axis.axis.options)}" if axis else ""
        for agent, label, measured in _of_agents(found, claim, found.courses(axis)):
            everyone, one = found.get("people", agent=agent, modality="", condition=""), measured._replace(agent=label)
            if everyone is not None and (everyone.value or 0) < FEWEST:
                one = one._replace(verdict="not decided", test=f"fewer than {FEWEST} people", p_value=None)
            said.setdefault(one, one._replace(agent=label + reading))
    yield from said.values()


def _of_agents(found: Results, claim: PaperClaim, courses: Sequence[Course]) -> Iterator[tuple[str, str, Judged]]:
    """Each agent that speaks to a claim, what tables call it, and what it says to the claim."""
    subjects = [one for one in courses if one.subject]
    if claim.judge in _OF_MODALITIES:
        told = [one for one in subjects if one.cells[0].trials and one.cells[0].dose == 0]
        for agent, own in grouped(told, lambda one: one.agent).items():
            by = {one.modality: one.cells[0] for one in sorted(own, key=lambda one: by_fidelity(one.modality))}
            shown = found.where("modality_effect", agent=agent)
            if shown and (said := _of_modalities(found, agent, by, claim)):
                yield agent, agent, said
        return
    judge = _over_rates if claim.judge in _OVER_RATES else _told_the_truth
    of_strategy = [one for one in courses if one.agent in found.reconstructed]
    for one in of_strategy if claim.of == "strategy" else subjects:
        heard = one.played and one.played[0].dose == 0 and not (one.blind and claim.judge in _OVER_RATES)
        if heard and spec_name(one.modality) == claim.modality and (said := judge(one, claim)):
            yield one.agent, one.label, said


def not_judged(found: Results) -> str:
    """Why no claim is judged; empty if all are.

    Claims are held against agents on a box that keeps its rules, by tests that hold for one look.
    """
    if rules := found.fact("overview", "rules"):
        return f"No claim is judged: {rules}"
    one_look = "No claim is judged: the tests hold for one look, when all planned trials are played."
    return one_look * bool(found.progress.every_look)


def _every_judged(found: Results) -> Iterator[tuple[PaperClaim, Judged]]:
    """Every claim with what each agent says to it, or that nothing was measured; without verdicts where none holds."""
    why = not_judged(found)
    for claim in paper_claims():
        for one in [*judged(found, claim)] or [Judged()]:
            yield claim, one._replace(verdict="not judged", test=why, p_value=None) if why and one.here else one


def _table(found: Results) -> Lines:
    yield ["place", "quote", "paper", "reanalysis", "agent", "this study", "verdict", "test", "P"]
    for claim, one in _every_judged(found):
        paper = [claim.place, claim.quote, claim.value, claim.recomputed]
        yield [*paper, one.agent, one.here, one.verdict, one.test, p_cell(one.p_value)]


def _measured(found: Results) -> Lines:
    """What was measured of the claims, as the page shows it: without the reanalysis of the paper and the tests."""
    yield from ([row[i] for i in (0, 1, 2, 4, 5, 6, 8)] for row in _table(found) if row[5])


_CLAIMS = Table("claims", _table, 8)

_NOTE = Note(
    "Quoted from Probing Embodied LLMs: When Higher Observation Fidelity Hurts Problem Solving. A verdict concerns the "
    "whole statement, not one of its numbers.",
    "The paper used other agents, another box and another prompt: agreement or disagreement of single numbers is not a "
    "replication. Each test is at the 5 % level, not corrected for the number of statements.",
    "All claims, a reanalysis of the paper's counts and each test are in tables/claims.csv.",
)

_VERDICTS = Note(
    "Compatible: no difference from the paper's value was detected, and the study shows the pattern of the statement. "
    "Borne out: it shows the pattern of a statement without a value.",
    "Not compatible: the study contradicts its value or pattern. Not decided: it does neither, which is no evidence.",
)


def _show(found: Results) -> Iterator[Part]:
    counts = Counter(one.verdict for _, one in _every_judged(found) if one.here)
    said = ", ".join(f"{n} {verdict}" for verdict, n in counts.most_common())
    answer = f"Of {counts.total()} comparisons: {said}." if counts else ""
    blocks: list[Block] = [Table("claims", _measured, 6), _VERDICTS, _NOTE]
    yield Part("The paper's claims", answer, [*filter(None, [not_judged(found)]), *blocks])


def _rows(numbers: OpenedStudy) -> Iterator[Fact]:
    for agent in numbers.study.agents:
        if spec_kind(agent) == "human-inspired":
            said = "a reconstruction of the paper's strategy, whose algorithm is not public"
            yield Fact(about=RECONSTRUCTED, name=numbers.study.label_of(agent), text=said)


SECTIONS = (Section("claims", "The paper's claims", _rows, _show, (_CLAIMS,)),)
