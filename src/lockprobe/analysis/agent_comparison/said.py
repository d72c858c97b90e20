"""What the comparisons of agents say, in plain words: who solves more, what noise does to whom, who is faster."""

from __future__ import annotations

from lockprobe.analysis.agent_comparison.pair import Comparison
from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.proportions import ALPHA
from lockprobe.analysis.speaking import begun, p_said, percent, verb
from lockprobe.analysis.summary import StudySummary

__all__ = ["comparison_said", "ranking_said"]

Name = tuple[str, str]


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
    names = _names(summary)
    said = [
        f"{names[row.agent, row.modality]} {percent(row.success.value)} ({_rank(*row.ranks)})"
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


def comparison_said(one: Comparison, summary: StudySummary) -> list[str]:
    """One pair: who solves the box more often; whether noise helps one more; who needs fewer steps."""
    names, pairs = _names(summary), sum(other.among == one.among for other in summary.comparisons)
    second, first = names[one.second], names[one.first]
    broken = ", the largest p-value over what became of broken trials" if one.bounded else ""
    shares = (
        f"{percent(one.second_share)} against {percent(one.first_share)} of the {one.success.pairs} trials that both "
        f"finished ({_points(one.success)}; {_test(one)}, {_p(one.success_adjusted, pairs)}{broken})"
    )
    if one.verdict:
        solves = verb(one.second[0], "solves", "solve")
        said = [f"{second} {solves} the box {'more' if one.verdict > 0 else 'less'} often than {first}: {shares}."]
    else:
        said = [f"{second} and {first} cannot be told apart by how often they solve the box: {shares}."]
    if one.interaction:
        said.append(_changes(one, second, first, pairs))
    return [*map(begun, said), begun(_steps(one, second, first, pairs))]


def _changes(one: Comparison, second: str, first: str, pairs: int) -> str:
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
            f"False reports do not do the same to both: {where} the success of {second} {more} than that of {first} "
            f"({_points(clearest.change)}, the clearest change; {test})."
        )
    return (
        f"That false reports help one of them more than the other is not detectable: {where} their changes differ "
        f"most clearly ({_points(clearest.change)}; {test})."
    )


def _steps(one: Comparison, second: str, first: str, pairs: int) -> str:
    found = one.steps
    interval = (
        "" if found.low is None or found.high is None else f", 95 % interval {found.low:+.1f} to {found.high:+.1f}"
    )
    test = f"{found.value:+.1f} steps{interval}; {_p(one.steps_adjusted, pairs)}".replace("-", "\N{MINUS SIGN}")
    if one.steps_verdict:
        needs = verb(one.second[0], "needs", "need")
        return (
            f"{second} {needs} {'fewer' if one.steps_verdict < 0 else 'more'} steps than {first}, an unsolved trial "
            f"counted with its whole budget ({test})."
        )
    return f"That one needs fewer steps than the other is not detectable ({test})."


def _test(one: Comparison) -> str:
    return "people and luck taken together" if one.people else "agents exchanged within luck"


def _names(summary: StudySummary) -> dict[Name, str]:
    return {(agent.agent, agent.modality): agent.called for agent in summary.agents}


def _rank(low: int, high: int) -> str:
    return f"rank {low}" if low == high else f"rank {low} to {high}"


def _points(found: BlockMean) -> str:
    interval = (
        ""
        if found.low is None or found.high is None
        else (f", 95 % interval {100 * found.low:+.0f} to {100 * found.high:+.0f}")
    )
    return f"{100 * found.value:+.0f} points{interval}".replace("-", "\N{MINUS SIGN}")


def _p(value: float | None, pairs: int, beside: str = "") -> str:
    if value is None:
        return "not tested"
    looked = [beside] * bool(beside) + [f"{pairs} pairs"] * (pairs > 1)
    return p_said(value) + (f", corrected for {' and '.join(looked)}" if looked else "")
