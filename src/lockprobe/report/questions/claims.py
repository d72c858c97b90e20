"""The paper's claims: each beside what the study measured of it, with a verdict, from the rows of all questions.

Loop rates are compared as the paper compares them, over whole trials: shorter trials hold fewer loops by chance alone.
Claims about effects and onset of loops are compared with tests at equal steps. A claim about all three modalities can
be contradicted by an agent that was not shown the box in all of them, and not borne out.
"""

from __future__ import annotations

import math
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib.resources import files
from itertools import pairwise
from typing import Literal, NamedTuple

from lockprobe.foundation.formatting import bracketed, p_cell, p_value, percent, points, range_of, share
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import spec_kind, spec_name
from lockprobe.report.format import TextTable
from lockprobe.report.prose import false_reports
from lockprobe.report.rows import Cell, Course, Estimate, Fact, Results, clearness
from lockprobe.report.section import Cells, Listed, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import points_cell
from lockprobe.statistics import published
from lockprobe.statistics.conditions.factors import READING_FACTORS
from lockprobe.statistics.conditions.modalities import by_fidelity, spoken
from lockprobe.statistics.distributions import holm, welch_test
from lockprobe.statistics.proportions import (
    ALPHA,
    Difference,
    Proportion,
    difference,
    proportion,
    ratio,
)
from lockprobe.trial.record import PLAIN_WORDS, STATES

_PAPERS_STRATEGY = "the paper's strategy"
"""What the facts that name its reconstructions are about."""

_NEAR = 0.1
"""How far a minimum "near 40 %" may lie from it: the next flip rate of the paper."""

_LOOPS = ("no change with the flip rate", "fewer loops at higher flip rates", "more loops at higher flip rates")
"""By what is detected: nothing, the pattern of the paper, its opposite."""

_OVER_RATES = "permutation test, corrected for all flip rates"
_LATER = "{:.2f} (hazard ratio of a first loop, higher flip rates over the lowest)"

_LINES = {"inverted U": 1, "U": -1}
"""What two lines show: a rise before a fall, or a fall before a rise."""


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


# A sign is what a valid test says of the pattern of a claim: 1 shows it, -1 its opposite, 0 neither.


def _sign(p: float | None, direction: float) -> int:
    """From a two-sided test, where a positive direction is that of the claim."""
    return 0 if p is None or p >= ALPHA or not direction else 1 if direction > 0 else -1


def _pattern(sign: int) -> str:
    """The verdict on a claim that is a pattern and no figure."""
    return ("not decided", "borne out", "not compatible")[sign]


def _figure(p: float | None, sign: int = 1) -> str:
    """The verdict on a figure with a pattern, from the test that may tell it from the paper's."""
    return "compatible" if (one := _pattern(-1 if p is not None and p < ALPHA else sign)) == "borne out" else one


def _share(cell: Cell, quantity: str = "success") -> Proportion:
    row = cell.get(quantity)
    if row is None or row.count is None or row.n is None or row.low is None or row.high is None:
        raise LookupError(f"{quantity} of {cell.agent} under {cell.condition} has no row")
    broken = int(cell.value("broken") or 0) if quantity == "success" else 0
    return replace(proportion(row.count, row.n), low=row.low, high=row.high, broken=broken)


def _change(first: Cell, second: Cell, quantity: str) -> Difference:
    found = difference(_share(first, quantity), _share(second, quantity))
    assert found is not None  # both have trials
    return found


def _differ(first: Cell, others: Sequence[Cell], quantity: str, direction: int) -> bool:
    """Whether one of them is shown to differ so from the first, corrected for their number (Holm)."""
    changes = [_change(first, one, quantity) for one in others]
    corrected = holm([one.p_value for one in changes])
    return any(_sign(p, direction * one.value) > 0 for p, one in zip(corrected, changes, strict=True))


def _as_paper(cell: Cell, quantity: str, paper: Proportion) -> Judged:
    """Whether a share is the paper's."""
    here = _share(cell, quantity)
    found = difference(paper, here)
    p = found.p_value if found else None
    said = f"{here.count}/{here.n}, {here.value:.3f} [{here.low:.3f}, {here.high:.3f}]"
    return Judged(said, _figure(p), f"Fisher, against {paper.count}/{paper.n}", p)


def _same_step(cell: Cell, paper: int) -> Judged:
    """The step by which 80 % of the trials are solved against the paper's."""
    row = cell.get("steps_to_solve", "80 %")
    step, early, late = (row.value, row.low, row.high) if row else (None, None, None)
    inside = (early or math.inf) <= paper <= (late or math.inf)
    said, *ends = ("not reached" if one is None else f"{one:g}" for one in (step, early, late))
    here = f"80 % by step {said} [{', '.join(ends)}]"
    return Judged(here, _figure(None, 1 if inside else -1), "95 % interval of the step, from the band")


# Claims about one agent, from what it did at a flip rate of 0 to the last one.


def _misread(course: Course) -> Judged | None:
    """Misreadings occur as often as in the paper."""
    cell = course.played[0]
    rate, spread, total = (cell.get("misinterpretations", of) for of in ("rate", "SD of rates", ""))
    if not (rate and spread and total) or rate.value is None or spread.value is None:
        return None
    if not total.value:
        return _never_misread(cell)
    paper, affected = published.TABLE1[spec_name(cell.modality)], cell.get("misinterpretations", "trials with any")
    p = welch_test((paper.mean, paper.sd, paper.trials), (rate.value, spread.value, rate.n or 0))
    here = f"{percent(rate.value, 1)} ± {percent(spread.value, 1)}, {total.value:g} in all"
    here += f", in {affected.count} of {affected.n} trials" if affected else ""
    return Judged(here, _figure(p), "Welch, on the rates per trial", p)


def _hallucinated(course: Course) -> Judged | None:
    """Most misreadings are of a joint that is said to have moved though it was reported blocked."""
    row = course.played[0].get("misread", "said moved")
    if row is None or row.low is None or row.high is None:
        return _never_misread(course.played[0])
    here = f"{row.count} of {row.n} misreadings claim moved after a report of blocked, "
    here += share(row.value, row.low, row.high)
    verdict = _pattern(1 if row.low > 0.5 else -1 if row.high < 0.5 else 0)
    return Judged(here, verdict, "95 % interval above or below one half, clustered by trial")


def _never_misread(cell: Cell) -> Judged | None:
    """Not one misreading: could that be chance, if as many trials had one as in the paper?"""
    misread, rate = cell.get("misread"), cell.get("misinterpretations", "rate")
    paper = published.TABLE1[spec_name(cell.modality)]
    found = difference(proportion(paper.affected, paper.trials), proportion(0, rate.n or 0)) if rate else None
    if not (misread and rate and found):
        return None
    here = f"none in {misread.n} claims of {rate.n} trials, at most {percent(misread.high, 1)}"
    test = f"Fisher, trials with a misreading, against {paper.affected}/{paper.trials}"
    return Judged(here, _pattern(_sign(found.p_value, -1)), test, found.p_value)


def _peak_of(course: Course) -> Cell | None:
    """What it did at the flip rate at which the paper has its peak."""
    return next((cell for cell in course.played if math.isclose(cell.dose or 0.0, published.PEAK)), None)


def _to_peak(course: Course, quantity: str) -> tuple[Cell, published.Shares, Difference]:
    """The cell at the peak, a share at 0 and there, and their difference."""
    peak = _peak_of(course)
    assert peak is not None  # what a claim needs
    shares = _share(course.played[0], quantity), _share(peak, quantity)
    return peak, shares, _change(course.played[0], peak, quantity)


def _in_points(change: Difference) -> str:
    return f"{points(change.value)} points {bracketed(change.value, change.low, change.high).partition(' ')[2]}"


def _rise_to_peak(course: Course) -> tuple[int, float | None]:
    """Whether success at the paper's peak is shown to be above that at 0, and the P value."""
    peak = _peak_of(course)
    row = next((row for cell, row in course.changes() if cell == peak), None)
    return (_sign(row.p_value, row.value or 0.0), row.p_value) if row else (0, None)


def _peak(course: Course) -> Judged:
    """Success rises to 0.4 by as much as in the paper, and is nowhere shown to be higher."""
    peak, shares, rise = _to_peak(course, "success")
    tested = next((row for cell, row in course.changes() if cell == peak), None)  # in pairs, as the page has it
    here = f"from 0 to 0.4 {points_cell(tested)} points" if tested else f"from 0 to 0.4 {_in_points(rise)}"
    if _differ(peak, course.played, "success", 1):
        return Judged(here, "not compatible", "Fisher, against every flip rate (Holm): higher at another")
    sign, p = _rise_to_peak(course)
    if sign:
        return Judged(here, _figure(None, sign), _OVER_RATES, p)
    p, of_paper = published.change_p("difference", shares), published.SOLVED_AT_40.value - published.SOLVED_AT_0.value
    test = f"z test against the paper's rise of {100 * of_paper:.0f} points; no rise to 0.4 was detected"
    return Judged(here, _pattern(-1 if rise.value < of_paper and p < ALPHA else 0), test, p)


def _ratio(course: Course) -> Judged:
    """Success rises from 0 to 0.4, and as many times as in the paper."""
    _, (one, two), _ = _to_peak(course, "success")
    here = f"{two.count}/{two.n} at 0.4 over {one.count}/{one.n} at 0"
    if found := ratio(one, two):
        here += f": {bracketed(found.value, found.low, found.high, '{:.2f}', 1)}"
    p, (sign, _) = published.change_p("ratio", (one, two)), _rise_to_peak(course)
    rise = ("no rise", "a rise", "a fall")[sign]
    test = f"z test of the log ratios, with half a trial added to each count; {rise} to 0.4 was detected"
    return Judged(here, _figure(p, sign), test, p)


def _effect(course: Course) -> Judged | None:
    """Success is above that at 0 for some flip rate; the opposite is a fall at the paper's moderate noise, 0.4."""
    if not (changes := course.changes()):
        return None
    rises = [(cell, row) for cell, row in changes if _sign(row.p_value, row.value or 0.0) > 0]
    if rises:
        cell, row = min(rises, key=lambda one: clearness(one[1]))
    else:
        peak, largest = _peak_of(course), max(changes, key=lambda one: one[1].value or 0.0)
        cell, row = next((one for one in changes if one[0] == peak), largest)
    here = f"{points(row.value or 0.0)} points from 0 to {cell.dose:g}"
    return Judged(here, _pattern(1 if rises else _rise_to_peak(course)[0]), _OVER_RATES, row.p_value)


def _fewer_loops(course: Course) -> int:
    """Whether loops are rarer than at 0: at 0.4, where the paper has its minimum, and nowhere more frequent."""
    if _differ(course.played[0], course.played[1:], "loop_rate", 1):
        return -1
    drop = _to_peak(course, "loop_rate")[2] if _peak_of(course) else None
    return _sign(drop.p_value, -drop.value) if drop else 0


def _loops(course: Course) -> Judged:
    """As many trials loop at 0 as in the paper, and more than elsewhere."""
    here, _, test, p, _ = _as_paper(course.played[0], "loop_rate", published.LOOPS_AT_0)
    low, high = (course.played[0].value("loop_rate", of) for of in ("uniform", "no-repeat"))
    here += "" if low is None or high is None else f"; by chance {range_of(low, high)}"
    sign = 0 if course.blind else _fewer_loops(course)
    why = "loops of a blind agent cannot depend on reports" if course.blind else f"{_LOOPS[sign]} detected"
    return Judged(here, _figure(p, sign), f"{test}; {why}", p)


def _drop(course: Course) -> Judged:
    """Loops are rarer at 0.4 than at 0, by as much as in the paper, and not still rarer far from it."""
    peak, (one, two), drop = _to_peak(course, "loop_rate")
    far = [cell for cell in course.played if abs((cell.dose or 0.0) - published.PEAK) > _NEAR + 1e-9]
    lower = _differ(peak, far, "loop_rate", -1)
    p = published.change_p("difference", (one, two), published.LOOPED)
    why = "fewer loops far from 0.4" if lower else _LOOPS[_fewer_loops(course)]
    here = f"{one.count}/{one.n} to {two.count}/{two.n}, {_in_points(drop)}"
    sign = -1 if lower else _sign(drop.p_value, -drop.value)
    return Judged(here, _figure(p, sign), f"z test of the two differences; {why} detected", p)


def _loops_again(course: Course) -> Judged | None:
    """First loops come later and then sooner again; a first line that rises, or a second that falls, contradicts it."""
    row, *lines = (course.get("two_lines", f"first loops{of}") for of in ("", ", first line", ", second line"))
    known = [(line.value, line.p_value) for line in lines if line is not None and line.value is not None]
    if row is None or len(known) < 2:
        return None
    ways = ("is constant", "rises", "falls")
    slopes = [ways[(z > 0) - (z < 0)] + (f" ({p_value(p)})" if p is not None else "") for z, p in known]
    here = f"hazard of a first loop {slopes[0]} up to {row.value:.2g}, {slopes[1]} above"
    first, second = holm([p for _, p in known])
    against = -1 in (_sign(first, -known[0][0]), _sign(second, known[1][0]))
    against = against and not any(cell.value("broken") for cell in course.cells)
    sign = -1 if against else -_sign(row.p_value, _LINES.get(row.note, 0))
    test = "loop onset, two lines; assumes that solved trials would have looped like the others"
    return Judged(here, _pattern(sign), test, row.p_value)


def _noted(quantity: str, of: str, here: str, test: str, **signs: int) -> Callable[[Course], Judged | None]:
    """Whether the note of a number over all flip rates names the pattern of a claim (1) or its opposite (-1)."""

    def judge(course: Course) -> Judged | None:
        row = course.get(quantity, of)
        if row is None or row.p_value is None:
            return None
        said = "" if row.value is None else here.format(row.value)
        return Judged(said, _pattern(_sign(row.p_value, signs.get(row.note, 0))), test, row.p_value)

    return judge


def _correlation(course: Course) -> Judged | None:
    """R is negative, and as large as in the paper."""
    row = course.get("loop_success", "correlation")
    if row is None or row.value is None or row.low is None or row.n is None or row.n < 4 or abs(row.value) == 1:
        return None
    p, sign = published.correlation_p(row.value, row.n), _sign(row.p_value, -row.value)
    here = f"{bracketed(row.value, row.low, row.high, '{:.2f}', 1)} over {row.n} points"
    which = ("no correlation was detected", "r is negative", "r is positive")[sign]
    return Judged(here, _figure(p, sign), f"Fisher's z test; {which}; neither value is evidence of harm by loops", p)


_OF_ONE: Mapping[str, Callable[[Course], Judged | None]] = {
    "reference": lambda course: _as_paper(course.played[0], "success", published.REFERENCE),
    "reference-steps": lambda course: _same_step(course.played[0], published.REFERENCE_STEPS),
    "misinterpretation": _misread,
    "hallucination": _hallucinated,
    "baseline": lambda course: _as_paper(course.played[0], "success", published.SOLVED_AT_0),
    "peak": _peak,
    "ratio": _ratio,
    "effect": _effect,
    "shape": _noted("two_lines", "success", "the lines meet at {:.2f}", "two lines", **_LINES),
    "loops": _loops,
    "loops-drop": _drop,
    "loops-rise": _loops_again,
    "onset": _noted("hazard_ratio", "first loops", _LATER, "loop onset, log-rank", later=1, sooner=-1),
    "correlation": _correlation,
}


# Claims about several modalities, told the truth (Sec. 3.1).


class _Shown(NamedTuple):
    """One agent by the modality in which it was shown the box, from low to high fidelity."""

    found: Results
    agent: str
    by: Mapping[str, Cell]

    @property
    def three(self) -> tuple[str, str, str]:
        """The paper's modalities. Its ground truth is a state; reports that tell outcomes too stand for it if alone."""
        return "rgb", "rgbd", next((one for one in PLAIN_WORDS if one in self.by), STATES)

    def pattern(self, sign: int) -> str:
        """The verdict on what is said of three modalities, which only all three can show."""
        return _pattern(0 if sign > 0 and not set(self.three) <= self.by.keys() else sign)

    @property
    def pairs(self) -> Mapping[tuple[str, str], Estimate]:
        """Every two modalities, the one of lower fidelity first: the hazard ratio of solving, second over first."""
        rows = self.found.where("hazard_ratio", agent=self.agent, of="modalities")
        return {(row.versus_modality, row.modality): row for row in rows if row.value is not None}

    def sooner(self, *pair: str) -> tuple[int, float | None]:
        """Whether the box is solved sooner in the first of two modalities, corrected for the pairs."""
        row = self.pairs.get((pair[0], pair[1]))
        return (_sign(row.p_value, 1 - (row.value or 0.0)), row.p_value) if row else (0, None)


def _by_modality(said: Mapping[str, str], between: str = "; ") -> str:
    return between.join(f"{one} with {spoken(modality)}" for modality, one in said.items())


def _final(shown: _Shown) -> Judged:
    """As many trials are solved as in the paper, in every modality."""
    same = {modality: _as_paper(cell, "success", published.MODALITY) for modality, cell in shown.by.items()}
    p = min((p for p in holm([one.p_value for one in same.values()]) if p is not None), default=None)
    verdict = _figure(p, int(set(shown.three) <= shown.by.keys()))
    test = "Fisher, against 8/10 in each modality, corrected for their number"
    return Judged(_by_modality({modality: one.here for modality, one in same.items()}), verdict, test, p)


def _order(shown: _Shown) -> Judged | None:
    """The box is solved sooner the lower the fidelity is, with RGB-D in between."""
    trend = shown.found.get("modality_effect", agent=shown.agent, of="trend over fidelity")
    if trend is None or trend.p_value is None:
        return None
    means = {modality: cell.value("mean_steps_all") or 0.0 for modality, cell in shown.by.items()}
    sign = _sign(trend.p_value, -(trend.value or 0.0))
    pairs = [shown.sooner(*pair)[0] for pair in pairwise(shown.three)]
    if sign > 0 and (-1 in pairs or [*means.values()] != sorted(means.values())):
        sign = -1 if -1 in pairs else 0
    here = f"mean steps {_by_modality({modality: f'{mean:.1f}' for modality, mean in means.items()}, ', ')}"
    test = "log-rank test for a trend over fidelity, and the order of the mean steps"
    return Judged(here, shown.pattern(sign), test, trend.p_value)


def _steps(shown: _Shown) -> Judged | None:
    """80 % are solved by the paper's steps, and sooner with RGB than with ground truth."""
    lowest, _, highest = shown.three
    steps = {lowest: published.STEPS_TO_80["rgb"], highest: published.STEPS_TO_80["symbolic"]}
    same = {one: _same_step(shown.by[one], step) for one, step in steps.items() if one in shown.by}
    if not same:
        return None
    sign, p = shown.sooner(lowest, highest)
    outside = any(one.verdict == "not compatible" for one in same.values())
    test = "95 % intervals of the steps, from the bands, and log-rank of RGB against positions in words"
    here = _by_modality({one: said.here for one, said in same.items()})
    return Judged(here, _figure(None, -outside or sign), test, p)


def _depth(shown: _Shown) -> Judged | None:
    """RGB-D is slower than RGB, however its depth is shown."""
    pairs = [pair for pair in shown.pairs if tuple(map(spec_name, pair)) == ("rgb", "rgbd")]
    return _paced(shown, pairs[:1], _pattern, "log-rank, corrected for the pairs")


def _outpaces(shown: _Shown) -> Judged | None:
    """RGB is faster than RGB-D, and RGB-D faster than ground truth."""
    pairs = [pair for pair in pairwise(shown.three) if set(pair) <= shown.by.keys()]
    return _paced(shown, pairs, shown.pattern, "log-rank of the two pairs, corrected; the larger P value")


def _paced(shown: _Shown, pairs: Sequence[tuple[str, str]], verdict: Callable[[int], str], test: str) -> Judged | None:
    """The box is solved sooner in the first modality of each pair."""
    if not pairs:
        return None
    signs, ps = zip(*(shown.sooner(*pair) for pair in pairs), strict=True)
    rows = [(shown.pairs[pair].value, *map(spoken, pair)) for pair in pairs if pair in shown.pairs]
    ratios = ", ".join(f"{value:.2f} ({second} over {first})" for value, first, second in rows)
    p = max((p for p in ps if p is not None), default=None)
    return Judged(f"hazard ratio of solving: {ratios}", verdict(min(signs)), test, p)


def _faster(shown: _Shown) -> Judged | None:
    """The human-inspired strategy, told the state, is faster than an agent in every modality."""
    papers, hazards = shown.found.facts_about(_PAPERS_STRATEGY), dict[str, tuple[float, float]]()
    for row in shown.found.where("hazard_ratio", of=""):  # of the row's agent over the other one
        sides = (row.versus, row.versus_modality), (row.agent, row.modality)
        power = -1 if sides[0][0] in papers and sides[0][1] in PLAIN_WORDS else 1
        (name, told), (slower, modality) = sides[::-power]
        known = name in papers and told in PLAIN_WORDS and slower == shown.agent and modality in shown.by
        if known and row.p_value is not None and row.value:
            hazards[modality] = row.value**power, row.p_value
    if not hazards:
        return None
    refuted = [p for p in holm([p for hazard, p in hazards.values() if hazard < 1]) if p is not None and p < ALPHA]
    every = hazards.keys() >= shown.by.keys() and all(_sign(p, hazard - 1) > 0 for hazard, p in hazards.values())
    ratios = _by_modality({modality: f"{hazard:.2f}" for modality, (hazard, _) in hazards.items()}, ", ")
    here = f"hazard ratio of solving, human-inspired over this agent: {ratios}"
    test = "log-rank, clustered by block; the largest P value"
    return Judged(here, shown.pattern(-1 if refuted else int(every)), test, max(p for _, p in hazards.values()))


_OF_MODALITIES: Mapping[str, Callable[[_Shown], Judged | None]] = {
    "modalities": _final,
    "modality-order": _order,
    "modality-outpaces": _outpaces,
    "modality-steps": _steps,
    "depth": _depth,
    "reference-faster": _faster,
}


def _reading(found: Results) -> Iterator[Judged]:
    """Whether what a false report is makes a difference here, for each agent that was told several kinds."""
    rows = [one for one in found.where("success_difference", of="", versus="") if one.axis in READING_FACTORS]
    for agent, own in grouped(rows, lambda row: row.agent).items():
        if agent in found.subjects:
            row = min(own, key=clearness)
            detected = sum(row.p_value is not None and row.p_value < ALPHA for row in own)
            here = f"{detected} of {len(own)} differences between readings were detected; the clearest: {row.condition}"
            here += f" minus {row.control} {bracketed(row.value, row.low, row.high)} points"
            test = "McNemar, and interval"
            yield Judged(here, "not decided", test, row.p_value, found.label(agent, row.modality))


def judged(found: Results, claim: PaperClaim) -> Iterator[Judged]:
    """What every agent that speaks to a claim says to it; of other readings of a false report only what differs."""
    if claim.measure == "reading":
        yield from _reading(found)
    said = dict[tuple[str, str, Judged], str]()
    for axis in (None, *(one for one in found.design.axes if one.of_flips and one.players)):
        reading = f", {false_reports(axis.options)}" if axis else ""
        for agent, modality, one in _of_agents(found, claim, found.courses(axis)):
            if one is not None:
                said.setdefault((agent, modality, one), reading)
    for (agent, modality, one), reading in said.items():
        yield one._replace(agent=found.label(agent, modality) + reading)


def _of_agents(
    found: Results, claim: PaperClaim, courses: Sequence[Course]
) -> Iterator[tuple[str, str, Judged | None]]:
    """Agent, modality (none for a claim about several) and what it says to a claim; None if it says nothing."""
    if judge := _OF_MODALITIES.get(claim.measure):
        told = [one for one in courses if one.subject and one.cells[0].trials and one.cells[0].dose == 0]
        for agent, own in grouped(told, lambda one: one.agent).items():
            if found.where("modality_effect", agent=agent):
                by = {one.modality: one.cells[0] for one in sorted(own, key=lambda one: by_fidelity(one.modality))}
                yield agent, "", judge(_Shown(found, agent, by))
    papers = found.facts_about(_PAPERS_STRATEGY)
    for one in courses if claim.measure in _OF_ONE else ():
        speaks = one.agent in papers if claim.of == "strategy" else one.subject
        heard = not (claim.needs and one.blind) and (claim.needs != "peak" or _peak_of(one))
        if speaks and heard and spec_name(one.modality) == claim.modality and one.played and one.played[0].dose == 0:
            yield one.agent, one.modality, _OF_ONE[claim.measure](one)


def not_judged(found: Results) -> str:
    """Why no claim is judged; empty if all are.

    Claims are held against agents on a box that keeps its rules, by tests that hold for one look.
    """
    if rules := found.said("overview", "rules"):
        return f"No claim is judged: {rules[0]}"
    one_look = "No claim is judged: the tests hold for one look, when all planned trials are played."
    return one_look * bool(found.progress.every_look)


def _table(found: Results) -> TextTable:
    table = [["place", "quote", "paper", "reanalysis", "agent", "this study", "verdict", "test", "P"]]
    why = not_judged(found)
    for claim in paper_claims():
        paper = [claim.place, claim.quote, claim.value, claim.recomputed]
        for one in judged(found, claim):
            verdict = ["not judged", why, p_cell(None)] if why else [one.verdict, one.test, p_cell(one.p_value)]
            table.append([*paper, one.agent, one.here, *verdict])
        if table[-1][1] != claim.quote:
            table.append([*paper, "", "", "not measured", "", p_cell(None)])
    return table


_CLAIMS = Table("claims", _table, numeric_from=8)

_SHOWN = ("place", "quote", "paper", "agent", "this study", "verdict", "P")
"""Columns of the page; the file has the reanalysis of the paper's counts and the tests too."""


def _measured(found: Results) -> TextTable:
    """What was measured of the claims, as the page shows it."""
    head, *rows = _table(found)
    at = [head.index(name) for name in _SHOWN]
    return [[row[i] for i in at] for row in (head, *rows) if row[head.index("verdict")] != "not measured"]


_NOTE = Note(
    "Quoted from Probing Embodied LLMs: When Higher Observation Fidelity Hurts Problem Solving. A verdict concerns the "
    "whole statement, not one of its numbers.",
    "The paper used other agents, another box and another prompt: agreement or disagreement of single numbers is not a "
    "replication. Each test is at the 5 % level, not corrected for the number of statements.",
    "All claims, a reanalysis of the paper's counts and each test are in tables/claims.csv.",
)

_VERDICTS = """
Compatible: no difference from the paper's value was detected, which may only mean that there are few trials, and the \
study shows the pattern that the statement describes, if it describes one.
Borne out: the study shows the pattern of a statement without a value.
Not compatible: the study contradicts its value or pattern.
Not decided: the study neither shows nor contradicts it. This is no evidence against it.
"""


def _show(found: Results) -> Iterator[Part]:
    counts = Counter(verdict for *_, verdict, _, _ in _table(found)[1:] if verdict != "not measured")
    said = ", ".join(f"{n} {verdict}" for verdict, n in counts.most_common())
    answer = f"Of {counts.total()} comparisons: {said}." if counts else ""
    why = [Text(not_judged(found))] if not_judged(found) else []
    verdicts = Listed(_VERDICTS.strip().splitlines())
    yield Part("The paper's claims", answer, [*why, Cells(_measured(found), 6), verdicts, _NOTE])


def _rows(numbers: StudyNumbers) -> Iterator[Fact]:
    for agent in numbers.study.agents:
        if spec_kind(agent) == "human-inspired":
            yield Fact(about=_PAPERS_STRATEGY, name=numbers.study.label_of(agent), text="human-inspired")


SECTIONS = (Section(name="claims", title="The paper's claims", rows=_rows, show=_show, tables=(_CLAIMS,)),)
