"""The conclusion of a comparison of studies, in a sentence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from lockprobe.foundation.formatting import change, p_value, percent
from lockprobe.report.prose.subject import Subject
from lockprobe.statistics.agent_comparison.across_studies import Side, StudyDifference
from lockprobe.statistics.proportions import ALPHA


def leading(found: Sequence[StudyDifference]) -> list[StudyDifference]:
    """The differences that a conclusion is about: those of the first kind that there is."""
    return [one for one in found if one.kind == found[0].kind]


def comparison_of_studies_said(found: Sequence[StudyDifference], names: Mapping[Side, Subject]) -> str:
    """How many differences between studies were detected, and the clearest of them.

    The sentence is about all families of conditions, so it is corrected for their number too (Bonferroni).

    Args:
        found: All differences, those between studies first.
        names: What a sentence calls each side.
    """
    if not found or not found[0].kind.startswith("between"):
        return "No two studies have a trial to compare under a condition that they share."
    asked = leading(found)
    sizes = Counter(one.family for one in asked)
    what = "baselines of different studies" if found[0].kind == "between-baselines" else "studies"
    shown = [one for one in asked if one.verdict and len(sizes) * one.p_adjusted < ALPHA]
    clearest = min(shown or asked, key=lambda one: (one.p_adjusted, -abs(one.value)))
    first, second = names[clearest.first], names[clearest.second]
    size, more = _size(clearest, sizes[clearest.family], len(sizes)), _within_families(asked, shown)
    if not shown:
        among = "" if len(asked) == 1 else f" in {len(asked)} comparisons"
        where = f"{second.name} against {first.name} under {clearest.condition}"
        return (
            f"No difference between {what} was detected{among}, which does not show that there is none; "
            f"{'it is' if len(asked) == 1 else 'the clearest is'} {where}: {size}.{more}"
        )
    often = "more" if clearest.value > 0 else "less"
    solves = second.form("solves", "solve")
    said = f"{solves} the box {often} often than {first.name} under {clearest.condition}: {size}"
    if len(asked) == 1:
        return f"{second.first} {said}."
    were = "was" if len(shown) == 1 else "were"
    head = f"{len(shown)} of {len(asked)} differences between {what} {were} detected"
    return f"{head}{', the clearest' * (len(shown) > 1)}: {second.name} {said}.{more}"


def _within_families(asked: Sequence[StudyDifference], shown: Sequence[StudyDifference]) -> str:
    """How many more differences the tables mark, whose families are corrected apart."""
    more = sum(bool(one.verdict) for one in asked) - len(shown)
    return f" {more} more {'are' if more > 1 else 'is'} detected if each family is taken alone." if more else ""


def _size(one: StudyDifference, many: int, families: int) -> str:
    first, second = one.first_success, one.second_success
    sample = (
        f"{first.n} pairs of trials with common random numbers"
        if one.paired
        else f"{second.n} and {first.n} trials, independent samples"
    )
    beside = f" of its family and for {families} families of conditions" if families > 1 else ""
    corrected = f", corrected for {many} difference{'s' * (many > 1)}{beside}" if many > 1 or families > 1 else ""
    broken = ", whatever became of broken trials" if one.broken else ""
    return (
        f"{percent(second.value)} against {percent(first.value)} ({change(one.value, one.low, one.high)}; "
        f"{p_value(min(1.0, families * one.p_adjusted))}{corrected}{broken}; {sample})"
    )
