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
from collections.abc import Callable, Iterator, Mapping, Sequence
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
from lockprobe.statistics.distributions import holm, welch_test
from lockprobe.statistics.modalities import by_fidelity, spoken
from lockprobe.statistics.proportions import ALPHA, Proportion, difference, proportion
from lockprobe.trial.record import PLAIN_WORDS

_NEAR = 0.1
"""How far a peak "near 40 %" may lie from it: the next flip rate of the paper."""

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
    needs: Literal["", "reports", "peak"] = ""
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

    ``agent`` is what tables call who was measured.
    """

    here: str
    verdict: str
    test: str
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


def _pattern(sign: int) -> str:
    """The verdict on a claim that is a pattern and no figure."""
    return ("not decided", "borne out", "not compatible")[sign]


def _figure(p: float | None, sign: int = 1) -> str:
    """The verdict on a figure with a pattern, from the test that may tell it from the paper's."""
    return "compatible" if (one := _pattern(-1 if p is not None and p < ALPHA else sign)) == "borne out" else one


def _share_of(cell: Cell, quantity: str) -> Proportion:
    row = cell.get(quantity)
    if row is None or row.count is None or row.n is None or row.low is None or row.high is None:
        raise LookupError(f"{quantity} of {cell.agent} under {cell.condition} has no row")
    broken = int(cell.value("broken") or 0) if quantity == "success" else 0
    return replace(proportion(row.count, row.n), low=row.low, high=row.high, broken=broken)


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
    if claim.quantity == "success":  # in pairs, as the page has it
        change: Any = next((row for cell, row in course.changes() if cell == peak), None)
    else:
        change = difference(_share_of(course.played[0], claim.quantity), _share_of(peak, claim.quantity))
    return _sign(change.p_value, claim.way * (change.value or 0.0)) if change else 0


# Claims about one agent, from what it did at a flip rate of 0 to the last one.


def _share(course: Course, claim: PaperClaim) -> Judged:
    """A share at 0 is the paper's; with a ``way`` it moves so up to the paper's peak."""
    here, paper = _share_of(course.played[0], claim.quantity), proportion(*claim.paper)
    found, test, sign = difference(paper, here), f"Fisher, against {paper.count}/{paper.n}", 1
    if claim.way:
        back = _beyond(course.played[0], course.played[1:], claim, -claim.way)
        sign = 0 if course.blind else -1 if back else _moved(course, claim)
        test += f"; of a change up to 0.4 {_FOUND[sign]}"
    p = found.p_value if found else None
    return Judged(_shown(here), _figure(p, sign), test, p)


def _change(course: Course, claim: PaperClaim) -> Judged | None:
    """A share moves from 0 to the paper's peak, nowhere further, and by as much as in the paper."""
    if (peak := _peak_of(course)) is None:
        return None
    one, two = (_share_of(cell, claim.quantity) for cell in (course.played[0], peak))
    near = 0.0 if claim.quantity == "success" else _NEAR
    far = [cell for cell in course.played if abs((cell.dose or 0.0) - published.PEAK) > near + 1e-9]
    sign = -1 if _beyond(peak, far, claim, claim.way) else _moved(course, claim)
    here, test, p = f"{one.count}/{one.n} at 0, {two.count}/{two.n} at 0.4", _FOUND[sign], None
    if claim.size in ("difference", "ratio"):
        p = published.change_p(
            claim.size, (one, two), published.SOLVED if claim.quantity == "success" else published.LOOPED
        )
        test = f"z test of the {claim.size}, against the paper's; of the change {test}"
    return Judged(here, _figure(p, sign), test, p)


def _step(course: Course, claim: PaperClaim) -> Judged:
    """The step by which 80 % of the trials are solved is the paper's."""
    here, sign = _step_of(course.played[0], claim.paper[0])
    return Judged(here, _figure(None, sign), "95 % interval of the step, from the band")


def _step_of(cell: Cell, paper: int) -> tuple[str, int]:
    row = cell.get("steps_to_solve", "80 %")
    step, early, late = (row.value, row.low, row.high) if row else (None, None, None)
    said, *ends = ("not reached" if one is None else f"{one:g}" for one in (step, early, late))
    inside = (early or math.inf) <= paper <= (late or math.inf)
    return f"80 % by step {said} [{', '.join(ends)}]", 1 if inside else -1


def _misread(course: Course, _: PaperClaim) -> Judged | None:
    """Misreadings occur as often as in the paper."""
    rate, spread, total = (course.played[0].get("misinterpretations", of) for of in ("rate", "SD of rates", ""))
    if not (rate and spread and total) or rate.value is None or spread.value is None:
        return None
    paper = published.TABLE1[spec_name(course.modality)]
    p = welch_test((paper.mean, paper.sd, paper.trials), (rate.value, spread.value, rate.n or 0))
    here = f"{percent(rate.value, 1)} ± {percent(spread.value, 1)}, {total.value:g} in all"
    return Judged(here, _figure(p), "Welch, on the rates per trial", p)


def _half(course: Course, claim: PaperClaim) -> Judged | None:
    """A share is above one half."""
    row = course.played[0].get(claim.quantity, claim.part)
    if row is None or row.low is None or row.high is None:
        return None
    verdict = _pattern(1 if row.low > 0.5 else -1 if row.high < 0.5 else 0)
    return Judged(f"{row.count} of {row.n}, {entry_text(row)}", verdict, "95 % interval above or below one half")


def _effect(course: Course, _: PaperClaim) -> Judged | None:
    """Success is above that at 0 for some flip rate; the opposite is a fall at the paper's moderate noise, 0.4."""
    if not (changes := course.changes()):
        return None
    rises = [(cell, row) for cell, row in changes if _sign(row.p_value, row.value or 0.0) > 0]
    at_peak = [(cell, row) for cell, row in changes if cell == _peak_of(course)]
    largest = max(changes, key=lambda one: one[1].value or 0.0)
    cell, row = min(rises, key=lambda one: clearness(one[1])) if rises else (at_peak or [largest])[0]
    sign = _sign(row.p_value, row.value or 0.0) if rises or at_peak else 0
    here = f"{entry_text(row)} points from 0 to {cell.dose:g}"
    return Judged(here, _pattern(sign), "permutation test, corrected for all flip rates", row.p_value)


def _row(course: Course, claim: PaperClaim) -> Judged | None:
    """A number over all flip rates shows the pattern by its sign or its note; a correlation is the paper's."""
    row = course.get(claim.quantity, claim.part)
    if row is None or row.p_value is None:
        return None
    sign = _sign(row.p_value, claim.way * (row.value or 0.0) if claim.way else claim.signs.get(row.note, 0))
    here = f"{claim.quantity.replace('_', ' ')} {entry_text(row)}{f', {row.note}' * bool(row.note)}"
    if claim.size != "correlation":
        return Judged(here, _pattern(sign), f"{row.test}; {_FOUND[sign]}", row.p_value)
    if row.n is None or row.value is None or row.n < 4 or abs(row.value) == 1:
        return None
    p = published.correlation_p(row.value, row.n)
    return Judged(here, _figure(p, sign), f"Fisher's z test, over {row.n} points; {_FOUND[sign]}", p)


_OF_ONE: Mapping[str, Callable[[Course, PaperClaim], Judged | None]] = {
    "share": _share, "step": _step, "misread": _misread, "half": _half, "change": _change, "effect": _effect,
    "row": _row,
}  # fmt: skip


# Claims about several modalities, told the truth (Sec. 3.1).


class _Shown(NamedTuple):
    """One agent by the modality in which it was shown the box, from low to high fidelity.

    The paper's ground truth is a state; reports that tell outcomes too stand for it if alone.
    """

    found: Results
    agent: str
    by: Mapping[str, Cell]

    def named(self, modality: str) -> str:
        """The modality of the study that is the paper's."""
        return next((one for one in PLAIN_WORDS if one in self.by), modality) if modality == "symbolic" else modality

    def pattern(self, sign: int) -> int:
        """A sign of what is said of three modalities, which only all three can show."""
        return 0 if sign > 0 and not {*map(self.named, ("rgb", "rgbd", "symbolic"))} <= self.by.keys() else sign

    def sooner(self, pair: Sequence[str]) -> tuple[int, float | None, str]:
        """Whether the box is solved sooner in the first of two modalities, corrected for the pairs; P; the ratio."""
        first, second = map(self.named, pair)
        for row in self.found.where("hazard_ratio", agent=self.agent, of="modalities"):
            of = row.versus_modality, row.modality
            if of == (first, second) or tuple(map(spec_name, of)) == (*pair,) == ("rgb", "rgbd"):
                said = f"{entry_text(row)} ({spoken(of[1])} over {spoken(of[0])})"
                return _sign(row.p_value, 1 - (row.value or 1.0)), row.p_value, said
        return 0, None, ""


def _modalities(shown: _Shown, claim: PaperClaim) -> Judged:
    """As many trials are solved as in the paper, in every modality."""
    paper, shares = proportion(*claim.paper), {name: _share_of(cell, "success") for name, cell in shown.by.items()}
    tested = [one.p_value for share in shares.values() if (one := difference(paper, share))]
    p = min((p for p in holm(tested) if p is not None), default=None)
    here = "; ".join(f"{_shown(share)} with {spoken(modality)}" for modality, share in shares.items())
    test = f"Fisher, against {paper.count}/{paper.n} in each modality, corrected for their number"
    return Judged(here, _figure(p, shown.pattern(1)), test, p)


def _order(shown: _Shown, claim: PaperClaim) -> Judged | None:
    """The box is solved sooner the lower the fidelity is; no two neighbours contradict it."""
    row = shown.found.get("modality_effect", agent=shown.agent, of="trend over fidelity")
    if row is None or row.p_value is None:
        return None
    signs = [shown.sooner(pair)[0] for pair in claim.pairs]
    means = ", ".join(f"{cell.value('mean_steps_all'):.1f} with {spoken(name)}" for name, cell in shown.by.items())
    sign = shown.pattern(-1 if -1 in signs else _sign(row.p_value, -(row.value or 0.0)))
    return Judged(f"mean steps {means}", _pattern(sign), "log-rank test for a trend over fidelity", row.p_value)


def _paces(shown: _Shown, claim: PaperClaim) -> Judged | None:
    """The box is solved sooner in the first modality of each pair; with ``steps`` 80 % by the paper's steps."""
    steps = [_step_of(shown.by[at], n) for name, n in claim.steps.items() if (at := shown.named(name)) in shown.by]
    signs, ps, ratios = zip(*map(shown.sooner, claim.pairs), strict=True)
    if not (any(ratios) or steps):
        return None
    sign = -1 if any(inside < 0 for _, inside in steps) else min(signs)
    sign = sign if claim.measure == "depth" else shown.pattern(sign)
    p = max((one for one in ps if one is not None), default=None)
    said = [f"hazard ratio of solving {', '.join(filter(None, ratios))}"] if any(ratios) else []
    verdict = _figure(None, sign) if claim.steps else _pattern(sign)
    return Judged("; ".join([*(one for one, _ in steps), *said]), verdict, "log-rank, corrected for the pairs", p)


def _strategy(shown: _Shown, _: PaperClaim) -> Judged | None:
    """The human-inspired strategy needs fewer steps than an agent in every modality."""
    rows = [
        row
        for row in shown.found.where("steps_difference", agent=shown.agent, condition="")
        if row.versus in shown.found.reconstructed and row.versus_modality in PLAIN_WORDS and row.modality in shown.by
    ]
    if not rows or shown.found.several_p:
        return None
    signs = [_sign(row.p_value, row.value or 0.0) for row in rows]
    sign = -1 if -1 in signs else int(len(rows) == len(shown.by) and min(signs) > 0)
    here = "; ".join(f"{entry_text(row)} steps more with {spoken(row.modality)}" for row in rows)
    p = max((row.p_value for row in rows if row.p_value is not None), default=None)
    return Judged(here, _pattern(shown.pattern(sign)), f"{rows[0].test}; the largest P value", p)


_OF_MODALITIES: Mapping[str, Callable[[_Shown, PaperClaim], Judged | None]] = {
    "modalities": _modalities, "order": _order, "paces": _paces, "strategy": _strategy,
}  # fmt: skip


def judged(found: Results, claim: PaperClaim) -> Iterator[Judged]:
    """What every agent that speaks to a claim says to it; of other readings of a false report only what differs."""
    said = dict[tuple[str, Judged], str]()
    for axis in (None, *(one for one in found.design.axes if one.of_flips and one.players)):
        reading = f", {false_reports(axis.options)}" if axis else ""
        for agent, one in _of_agents(found, claim, found.courses(axis)):
            if one is not None:
                said.setdefault((agent, one), reading)
    yield from (one._replace(agent=agent + reading) for (agent, one), reading in said.items())


def _of_agents(found: Results, claim: PaperClaim, courses: Sequence[Course]) -> Iterator[tuple[str, Judged | None]]:
    """What tables call each agent, and what it says to a claim; None if it says nothing."""
    if several := _OF_MODALITIES.get(claim.judge):
        told = [one for one in courses if one.subject and one.cells[0].trials and one.cells[0].dose == 0]
        for agent, own in grouped(told, lambda one: one.agent).items():
            if found.where("modality_effect", agent=agent):
                by = {one.modality: one.cells[0] for one in sorted(own, key=lambda one: by_fidelity(one.modality))}
                yield agent, several(_Shown(found, agent, by), claim)
    for one in courses if claim.judge in _OF_ONE else ():
        speaks = one.agent in found.reconstructed if claim.of == "strategy" else one.subject
        heard = not (claim.needs and one.blind) and (claim.needs != "peak" or _peak_of(one))
        if speaks and heard and spec_name(one.modality) == claim.modality and one.played and one.played[0].dose == 0:
            yield one.label, _OF_ONE[claim.judge](one, claim)


def not_judged(found: Results) -> str:
    """Why no claim is judged; empty if all are.

    Claims are held against agents on a box that keeps its rules, by tests that hold for one look.
    """
    if rules := found.fact("overview", "rules"):
        return f"No claim is judged: {rules}"
    one_look = "No claim is judged: the tests hold for one look, when all planned trials are played."
    return one_look * bool(found.progress.every_look)


def _table(found: Results) -> Lines:
    yield ["place", "quote", "paper", "reanalysis", "agent", "this study", "verdict", "test", "P"]
    why = not_judged(found)
    for claim in paper_claims():
        paper, measured = [claim.place, claim.quote, claim.value, claim.recomputed], list(judged(found, claim))
        for one in measured:
            verdict = ["not judged", why, p_cell(None)] if why else [one.verdict, one.test, p_cell(one.p_value)]
            yield [*paper, one.agent, one.here, *verdict]
        if not measured:
            yield [*paper, "", "", "not measured", "", p_cell(None)]


def _measured(found: Results) -> Lines:
    """What was measured of the claims, as the page shows it: without the reanalysis of the paper and the tests."""
    return ([*row[:3], *row[4:7], row[8]] for row in _table(found) if row[6] != "not measured")


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
    counts = Counter(str(row[5]) for row in [*_measured(found)][1:])
    said = ", ".join(f"{n} {verdict}" for verdict, n in counts.most_common())
    answer = f"Of {counts.total()} comparisons: {said}." if counts else ""
    blocks: list[Block] = [Table("", _measured, 6), _VERDICTS, _NOTE]
    yield Part("The paper's claims", answer, [*filter(None, [not_judged(found)]), *blocks])


def _rows(numbers: OpenedStudy) -> Iterator[Fact]:
    for agent in numbers.study.agents:
        if spec_kind(agent) == "human-inspired":
            said = "a reconstruction of the paper's strategy, whose algorithm is not public"
            yield Fact(about=RECONSTRUCTED, name=numbers.study.label_of(agent), text=said)


SECTIONS = (Section("claims", "The paper's claims", _rows, _show, (_CLAIMS,)),)
