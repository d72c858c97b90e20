"""Words that several parts of a page use: who and what a sentence is about, and what its intervals are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from lockprobe.foundation.formatting import capital
from lockprobe.foundation.spec import PEOPLE, Spec, spec_name
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.report.rows import Course, Results
from lockprobe.statistics.clustered import FEWEST_BOXES
from lockprobe.statistics.conditions.axis import AGENT, FLIPS, Axis
from lockprobe.statistics.conditions.modalities import spoken
from lockprobe.statistics.published import PEAK
from lockprobe.trial.condition import TRUTH
from lockprobe.trial.plant_change import PLANT
from lockprobe.trial.record import PLAIN_WORDS


@dataclass(frozen=True, slots=True, kw_only=True)
class Subject:
    """The grammatical subject of a sentence.

    ``name`` is what a sentence calls it: ``llm:local (RGB)`` or ``people``, whose verbs are in the plural.
    """

    name: str
    plural: bool = False

    @classmethod
    def of(cls, agent: str, shown: str = "") -> Subject:
        """The subject that stands for an agent; ``shown`` is how the box was shown, where that has to be said."""
        plural = agent == PEOPLE
        name = "people" if plural else agent
        return cls(name=f"{name} ({shown})" if shown else name, plural=plural)

    @classmethod
    def seeing(cls, agent: str, modality: str) -> Subject:
        """The subject that stands for an agent in a modality, which is said unless it is plain words."""
        return cls.of(agent, "" if modality in PLAIN_WORDS else spoken(modality))

    def form(self, one: str, many: str) -> str:
        """The form of a word that agrees with it."""
        return many if self.plural else one

    @property
    def first(self) -> str:
        """Its name at the beginning of a sentence; a spec stays as it is.

        >>> Subject.of("participant").first, Subject.of("random").first
        ('People', 'random')
        """
        return capital(self.name) if self.plural else self.name


_KNOWN: Mapping[tuple[str, str], str] = {
    ("outcome", "fresh"): "false reports",
    ("outcome", "kept"): "false reports that stay",
    ("position", "fresh"): "false positions",
    ("position", "kept"): "false positions that stay",
    ("position", "noisy"): "noise on all positions",
}

_POSITION, _OUTCOME = "the reported position of the attempted joint is inverted", "the reported outcome is inverted"

_CORRECTED = "a false position is corrected when another joint is attempted"
_STAY = "a false position stays until its joint is attempted again"

BOTH_FIT = "The paper does not say which of these false reports it has; its numbers fit agents under each."
"""Of several readings (``docs/readings.md``)."""


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
    words = {TRUTH: "told the truth"}
    for one in found.design.conditions:
        if not one.specs and one.modality not in PLAIN_WORDS:
            words[one.name] = spoken(one.modality)
        if found.several_p and one.p == 0:
            words[one.name] = "told the truth"
        if [spec_name(spec) for spec in one.specs] == ["flip"] and one.specs == (one.name,):
            rate, _, options = one.name.partition("?p=")[2].partition("&")
            reading = f", {reading_name(options).removeprefix('outcome inverted, ')}" * bool(options)
            words[one.name] = f"flip rate {rate}{reading}"
    return {one.name: words.get(one.name, one.name) for one in found.design.conditions}


def reading_name(options: str) -> str:
    """A reading by what is inverted and what becomes of it, for tables and legends.

    >>> reading_name(""), reading_name("others=kept"), reading_name("keep=0.5")
    ('outcome inverted, then corrected', 'outcome inverted, stays', 'keep=0.5')
    """
    said = Spec.parse(f"flip?{options}").options if options else {}
    if said.keys() - {"inverts", "others"}:
        return options
    if said.get("others") == "noisy":
        return "every position inverted independently"
    stay = "stays" if said.get("others") == "kept" else "then corrected"
    return f"{said.get('inverts', 'outcome')} inverted, {stay}"


def inverted(flip: OutcomeFlip, *, positions: bool) -> str:
    """What is inverted with the probability that the flip rate is, and how long reports of positions keep to it."""
    if not positions:
        return _OUTCOME
    if flip.others == "noisy":
        return "a reported position is inverted, for every joint in every report"
    if flip.inverts == "position":
        return f"{_POSITION} {'until its next attempt' if flip.keep == 1 else 'in one report'}"
    return f"{_OUTCOME}; {_STAY if flip.keep == 1 else _CORRECTED}"


_PICTURED = ("rgb", "rgbd")
"""Modalities, whose pictures can be false, blurred, noisy or covered."""


def cause(axis: Axis) -> str:
    """What may change an agent's success.

    >>> cause(FLIPS), cause(Axis(kind="tremble", dose="p")), cause(Axis(kind=AGENT, dose="t"))
    ('false reports', 'higher doses of tremble', 'higher values of t')
    """
    if axis.kind == AGENT:
        return f"higher values of {axis.dose}"
    if axis.name == FLIPS.name:
        return false_reports(axis.options)
    said = f"higher doses of {_short(axis)}"
    return f"{said} ({axis.options})" if axis.options else said


def at_dose(p: float, axis: Axis = FLIPS) -> str:
    """Under which condition, within a sentence.

    >>> at_dose(0), at_dose(0.4), at_dose(0, Axis(kind="tremble", dose="p", rest="nudge"))
    ('when told the truth', 'at a flip rate of 0.4', 'under nudge alone')
    >>> at_dose(0, Axis(kind="plant", dose="pose_error"))
    "with the study's own plant"
    """
    if p:
        return f"at a {axis.name} of {p:g}"
    if axis.kind == PLANT:
        return "with the study's own plant"
    if axis.rest:
        return f"under {axis.rest} alone"
    if axis.kind == AGENT:
        return f"at a {axis.dose} of 0"
    return "when told the truth" if axis.name == FLIPS.name else f"without {_short(axis)}"


def _short(axis: Axis) -> str:
    """An intervention goes by its name; pictures and plants have several doses."""
    return axis.name if axis.kind in (*_PICTURED, PLANT) else axis.kind


def rules_broken_said(against: int = 0, attempts: int = 0) -> str:
    """How many attempts broke the rules of the box; empty if none did."""
    return f"{against} of {attempts} attempts broke the rules of the box." if against else ""


def paper_rates(courses: Iterable[Course]) -> list[float]:
    """The flip rates of the paper's values, 0 and 0.4, that lie on the axis of these agents; none with one rate."""
    played = {cell.dose for course in courses for cell in course.cells if cell.dose is not None}
    return [rate for rate in (0.0, PEAK) if len(played) > 1 and min(played) <= rate <= max(played)]


def interval_kind(every_look: object) -> str:
    """What intervals of shares of solved trials are, those of people aside: for one look if ``every_look`` is false."""
    return "confidence sequences, which hold at every look" if every_look else "Wilson intervals"


def share_intervals_said(
    agents: Iterable[str], of: str = "Intervals", *, every_look: bool = False, boxes: int = 1
) -> str:
    """What intervals of the shares of these agents are, as a sentence: those of people are clustered by person.

    With ``every_look`` they hold at every look; those of success do where differences in success do. Of several
    ``boxes`` each counts alike.

    >>> share_intervals_said(["random"]), share_intervals_said(["participant"])
    ('Intervals are 95 % Wilson intervals.', 'Intervals are 95 % intervals clustered by person.')
    >>> share_intervals_said(["random"], every_look=True)
    'Intervals are 95 % confidence sequences, which hold at every look.'
    """
    people = {agent == PEOPLE for agent in agents}
    if people == {True}:
        return f"{of} are 95 % intervals clustered by person."
    kind = "intervals over boxes" if boxes >= FEWEST_BOXES else interval_kind(every_look)
    return f"{of} are 95 % {kind}{', clustered by person for people' * (True in people)}."


def success_and_loops_said(
    agents: Iterable[str], of: str = "Intervals", *, every_look: bool = False, boxes: int = 1
) -> str:
    """The same where shares of solved trials stand beside loop rates, whose intervals hold for one look.

    >>> success_and_loops_said(["random"], every_look=True).partition(" Intervals of loop")[2]
    ' rates are 95 % Wilson intervals.'
    """
    shown = [*agents]
    if not every_look:
        return share_intervals_said(shown, of, boxes=boxes)
    success = share_intervals_said(shown, "Intervals of success", every_look=True)
    loops = share_intervals_said(shown, "Intervals of loop rates")
    return success if set(shown) == {PEOPLE} else f"{success} {loops}"
