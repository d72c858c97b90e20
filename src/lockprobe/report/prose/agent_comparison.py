"""Sentences on comparisons of agents: success, the effect of false reports, and the number of steps."""

from __future__ import annotations

from lockprobe.foundation.formatting import change, minus, p_value, percent, range_said
from lockprobe.report.prose.subject import Subject, subjects_by_name
from lockprobe.statistics.agent_comparison.interaction import Interaction
from lockprobe.statistics.agent_comparison.pair import AgentComparison
from lockprobe.statistics.agent_comparison.paired import BlockMean
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.summary import StudySummary


def comparison_said(one: AgentComparison, summary: StudySummary) -> list[str]:
    """One pair: differences in success, in the effect of false reports and in the number of steps."""
    names, pairs = subjects_by_name(summary), sum(other.family == one.family for other in summary.comparisons)
    second, first = names[one.second], names[one.first]
    broken = "; interval and P value hold whatever became of broken trials" if one.bounded else ""
    shares = (
        f"{percent(one.second_share)} against {percent(one.first_share)} of the {one.success.pairs} trials that both "
        f"played ({_change(one.success)}; {_test(one)}, {_p(one.success_adjusted, pairs)}{broken})"
    )
    if one.verdict:
        solves, often = second.form("solves", "solve"), "more" if one.verdict > 0 else "less"
        said = [f"{second.first} {solves} the box {often} often than {first.name}: {shares}."]
    else:
        said = [f"No difference in success between {second.name} and {first.name} was detected: {shares}."]
    if one.interaction:
        said.append(_changes(one, one.interaction, second, first, pairs))
    return [*said, _steps(one, second, first, pairs)]


def _changes(one: AgentComparison, moved: Interaction, second: Subject, first: Subject, pairs: int) -> str:
    clearest = moved.clearest
    how = _test(one) if one.people else "sign-flip permutation test over blocks"
    test = f"{how}, {_p(moved.p_adjusted, pairs, 'all flip rates')}"
    where = f"from a flip rate of {moved.lowest:g} to {clearest.dose:g}"
    if moved.p_adjusted is not None and moved.p_adjusted < ALPHA:
        more = "rises more, or falls less," if clearest.change.value > 0 else "rises less, or falls more,"
        return (
            f"False reports affect the two differently: {where} the success of {second.name} {more} than that of "
            f"{first.name} ({_change(clearest.change)}, the clearest difference; {test})."
        )
    return (
        "No difference between the two in the effect of false reports was detected: the clearest is "
        f"{_change(clearest.change)}, {where} ({test})."
    )


def _steps(one: AgentComparison, second: Subject, first: Subject, pairs: int) -> str:
    found = one.steps
    interval = range_said(found.low, found.high, "{:+.1f}", 1)
    test = f"{minus(f'{found.value:+.1f}')} steps{interval}; {_p(one.steps_adjusted, pairs)}"
    if one.steps_verdict:
        needs = second.form("needs", "need")
        return (
            f"{second.first} {needs} {'fewer' if one.steps_verdict < 0 else 'more'} steps than {first.name}, "
            f"counting an unsolved trial with its whole budget ({test})."
        )
    return f"No difference in the number of steps was detected ({test})."


def _test(one: AgentComparison) -> str:
    if one.every_look:
        return "e-process"
    return "clustered by person and block" if one.people else "permutation test within blocks"


def _change(found: BlockMean) -> str:
    return change(found.value, found.low, found.high)


def _p(value: float | None, pairs: int, choices: str = "") -> str:
    if value is None:
        return "not tested"
    tried = [choices] * bool(choices) + [f"{pairs} pairs"] * (pairs > 1)
    return p_value(value) + (f", corrected for {' and '.join(tried)}" if tried else "")
