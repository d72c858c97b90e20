"""Words that several parts of a page use: who and what a sentence or a row is about, and what its intervals are."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from lockprobe.foundation.formatting import NONE, range_of
from lockprobe.foundation.spec import PEOPLE, Spec, spec_name
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.report.rows import Cell, Course, Results
from lockprobe.statistics.clustered import FEWEST_BOXES
from lockprobe.statistics.design import FLIPS, Axis
from lockprobe.statistics.modalities import spoken
from lockprobe.statistics.published import PEAK
from lockprobe.trial.condition import PLANT, TRUTH
from lockprobe.trial.record import PLAIN_WORDS

_KNOWN: Mapping[tuple[str, str], str] = {
    ("outcome", "fresh"): "false reports",
    ("outcome", "kept"): "false reports that stay",
    ("position", "fresh"): "false positions",
    ("position", "kept"): "false positions that stay",
    ("position", "noisy"): "noise on all positions",
}

_PICTURED = ("rgb", "rgbd")
"""Modalities, whose pictures can be false, blurred, noisy or covered."""


def false_reports(options: str) -> str:
    """False reports with these options of ``flip``, as the subject of a sentence.

    >>> false_reports(""), false_reports("others=kept"), false_reports("keep=0.5")
    ('false reports', 'false reports that stay', 'false reports (keep=0.5)')
    """
    said = Spec.parse(f"flip?{options}").options if options else {}
    known = _KNOWN.get((said.get("inverts", "outcome"), said.get("others", "fresh")))
    return known if known and said.keys() <= {"inverts", "others"} else f"false reports ({options})"


def condition_words(found: Results) -> dict[str, str]:
    """What a reader calls the conditions: told the truth, flip rate 0.4; others than flips by their names."""
    words, ways = {TRUTH: "told the truth"}, {one.modality for one in found.design.conditions}
    for one in found.design.conditions:
        acts, _, shown = one.name.partition(" + ")
        if not one.specs and one.modality not in PLAIN_WORDS:
            words[one.name] = spoken(one.modality)
        if found.several_p and one.p == 0:
            words[one.name] = "told the truth"
        if spec_name(acts) == "flip" and one.specs == (acts,) and shown in ("", one.modality):
            rate, _, options = acts.partition("?p=")[2].partition("&")
            seen = f", {spoken(shown)}" * (bool(shown) and len(ways) > 1)
            words[one.name] = f"flip rate {rate}" + f", {false_reports(options)}" * bool(options) + seen
    return {one.name: words.get(one.name, one.name) for one in found.design.conditions}


def inverted(flip: OutcomeFlip, *, positions: bool) -> str:
    """What is inverted with the probability that the flip rate is, and how long reports of positions keep to it."""
    if positions and flip.others == "noisy":
        return "a reported position is inverted, for every joint in every report"
    if positions and flip.inverts == "position":
        how = "until its next attempt" if flip.keep == 1 else "in one report"
        return f"the reported position of the attempted joint is inverted {how}"
    stays = "stays until its joint is attempted again"
    kept = f"; a false position {stays if flip.keep == 1 else 'is corrected when another joint is attempted'}"
    return f"the reported outcome is inverted{kept * positions}"


def cause(axis: Axis) -> str:
    """What may change an agent's success; an intervention goes by its name, pictures and plants have several doses.

    >>> cause(FLIPS), cause(Axis(kind="tremble", dose="p"))
    ('false reports', 'higher doses of tremble')
    """
    if axis.name == FLIPS.name:
        return false_reports(axis.options)
    said = f"higher doses of {axis.name if axis.kind in (*_PICTURED, PLANT) else axis.kind}"
    return f"{said} ({axis.options})" if axis.options else said


def at_dose(p: float) -> str:
    """At which flip rate, within a sentence.

    >>> at_dose(0), at_dose(0.4)
    ('when told the truth', 'at a flip rate of 0.4')
    """
    return f"at a {FLIPS.name} of {p:g}" if p else "when told the truth"


def at_lowest(found: Results) -> str:
    """Under which reports agents are compared without an effect of false ones, within a sentence."""
    return at_dose(next(iter(found.flip_rates), 0.0))


def rules_broken_said(against: int = 0, attempts: int = 0) -> str:
    """How many attempts broke the rules of the box; empty if none did."""
    return f"{against} of {attempts} attempts broke the rules of the box." if against else ""


def paper_rates(cells: Iterable[Cell]) -> list[float]:
    """The flip rates of the paper's values, 0 and 0.4, that lie on the axis of these cells; none with one rate."""
    played = {cell.p for cell in cells if cell.p is not None}
    return [rate for rate in (0.0, PEAK) if len(played) > 1 and min(played) <= rate <= max(played)]


def interval_kind(found: Results, *, success: bool = True) -> str:
    """What intervals of shares of trials are: of those solved (``success``), or of others, which hold for one look."""
    kind = "Wilson intervals"
    if len(found.boxes) >= FEWEST_BOXES:
        kind = "intervals over boxes"
    elif success and found.progress.every_look:
        kind = "confidence sequences, which hold at every look"
    people = any(one.agent == PEOPLE for one in found.design.players)
    return f"95 % {kind}{', clustered by person for people' * people}"


# What names the rows of tables: agents, and the flip rate or the condition that tells their rows apart.


def chance_said(cell: Cell) -> str:
    """The loop rate of random actions, from uniform to without immediate repeats."""
    low, high = (cell.value("loop_rate", of) for of in ("uniform", "no-repeat"))
    return NONE if low is None or high is None else range_of(low, high)


def told_apart(cells: Sequence[Cell]) -> tuple[str, Callable[[Cell], str]]:
    """What tells the rows of one agent apart, and its value in a row: the flip rate, or else the condition."""
    rates = {(cell.label, cell.p) for cell in cells}
    if None in {p for _, p in rates} or len(rates) < len({(cell.label, cell.condition) for cell in cells}):
        words = condition_words(cells[0].found)
        return "condition", lambda cell: words[cell.condition]
    return FLIPS.name, lambda cell: f"{cell.p:g}"


def played_subjects(found: Results) -> list[Course]:
    """The agents that the study is about, over flip rates; all agents if none of these has an ended trial."""
    played = [course for course in found.courses() if course.played]
    return [course for course in played if course.subject] or played


def over_rates(found: Results) -> bool:
    """Whether agents played at several flip rates."""
    return found.several_p and bool(played_subjects(found))
