"""Sentences on comparisons of agents: who solves more, whom false reports help more, who needs fewer steps."""

from __future__ import annotations

from lockprobe.analysis.agent_comparison.pair import AgentComparison
from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.proportions import ALPHA
from lockprobe.analysis.summary import StudySummary
from lockprobe.formatting import minus, p_value, percent, points, range_said
from lockprobe.prose.subject import Subject, subjects_by_name

__all__ = ["comparison_said", "ranking_said"]


def ranking_said(summary: StudySummary) -> str:
    """The agents that the study is about by success over all p: a sentence for each way of showing the box.

    Ranks are of the agents that were shown it alike. Empty for fewer than two of them.
    """
    shown = dict.fromkeys(row.modality for row in summary.standings if row.ranks)
    return " ".join(filter(None, (_ranking(summary, modality, several=len(shown) > 1) for modality in shown)))


def _ranking(summary: StudySummary, modality: str, *, several: bool) -> str:
    placed = [row for row in summary.standings if row.ranks and row.modality == modality]
    if len(placed) < 2:
        return ""
    names = subjects_by_name(summary)
    said = [
        f"{names[row.agent, row.modality].name} {percent(row.success.value)} ({_rank(*row.ranks)})"
        for row in placed
        if row.ranks
    ]
    between = [one for one in summary.comparisons if one.among == "subjects" and one.first[1] == modality]
    told, pairs = sum(one.verdict != 0 for one in between), len(between)
    apart = "they can be told apart" if pairs == 1 == told else "they cannot be told apart" if pairs == 1 else ""
    return (
        f"Solved over all flip rates{f', box shown as {modality}' * several}: {', '.join(said)}; "
        f"{apart or f'{told} of {pairs} pairs can be told apart'} on the same boxes with the same false reports."
    )


def comparison_said(one: AgentComparison, summary: StudySummary) -> list[str]:
    """One pair: who solves the box more often; whether noise helps one more; who needs fewer steps."""
    names, pairs = subjects_by_name(summary), sum(other.among == one.among for other in summary.comparisons)
    second, first = names[one.second], names[one.first]
    broken = ", the largest p-value over what became of broken trials" if one.bounded else ""
    shares = (
        f"{percent(one.second_share)} against {percent(one.first_share)} of the {one.success.pairs} trials that both "
        f"finished ({_points(one.success)}; {_test(one)}, {_p(one.success_adjusted, pairs)}{broken})"
    )
    if one.verdict:
        solves, often = second.form("solves", "solve"), "more" if one.verdict > 0 else "less"
        said = [f"{second.first} {solves} the box {often} often than {first.name}: {shares}."]
    else:
        said = [f"{second.first} and {first.name} cannot be told apart by how often they solve the box: {shares}."]
    if one.interaction:
        said.append(_changes(one, second, first, pairs))
    return [*said, _steps(one, second, first, pairs)]


def _changes(one: AgentComparison, second: Subject, first: Subject, pairs: int) -> str:
    moved = one.interaction
    if moved is None:
        return ""
    clearest = moved.clearest
    how = _test(one) if one.people else "signs of whole blocks of luck flipped"
    test = f"{how}, {_p(moved.p_adjusted, pairs, 'every flip rate')}"
    where = f"from a flip rate of {moved.lowest:g} to {clearest.p:g}"
    if moved.p_adjusted is not None and moved.p_adjusted < ALPHA:
        more = "rises more, or falls less," if clearest.change.value > 0 else "rises less, or falls more,"
        return (
            f"False reports do not do the same to both: {where} the success of {second.name} {more} than that of "
            f"{first.name} ({_points(clearest.change)}, the clearest change; {test})."
        )
    return (
        f"That false reports help one of them more than the other is not detectable: {where} their changes differ "
        f"most clearly ({_points(clearest.change)}; {test})."
    )


def _steps(one: AgentComparison, second: Subject, first: Subject, pairs: int) -> str:
    found = one.steps
    interval = range_said(found.low, found.high, "{:+.1f}", 1)
    test = f"{minus(f'{found.value:+.1f}', zeros=True)} steps{interval}; {_p(one.steps_adjusted, pairs)}"
    if one.steps_verdict:
        needs = second.form("needs", "need")
        return (
            f"{second.first} {needs} {'fewer' if one.steps_verdict < 0 else 'more'} steps than {first.name}, "
            f"an unsolved trial counted with its whole budget ({test})."
        )
    return f"That one needs fewer steps than the other is not detectable ({test})."


def _test(one: AgentComparison) -> str:
    return "people and luck taken together" if one.people else "agents exchanged within luck"


def _rank(low: int, high: int) -> str:
    return f"rank {low}" if low == high else f"rank {low} to {high}"


def _points(found: BlockMean) -> str:
    return f"{points(found.value)} points{range_said(found.low, found.high)}"


def _p(value: float | None, pairs: int, beside: str = "") -> str:
    if value is None:
        return "not tested"
    looked = [beside] * bool(beside) + [f"{pairs} pairs"] * (pairs > 1)
    return p_value(value) + (f", corrected for {' and '.join(looked)}" if looked else "")
