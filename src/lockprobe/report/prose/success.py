"""Sentences on success: the effect of a dose."""

from __future__ import annotations

from math import ceil

from lockprobe.foundation.formatting import capital, change, interval, p_value, percent, points
from lockprobe.report.prose.doses import at_dose, cause
from lockprobe.report.prose.idle import idle_doses_said
from lockprobe.report.prose.subject import subject_of
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.conditions.condition import ConditionSummary, Contrast
from lockprobe.statistics.proportions import Proportion

_MANY, _COPIES = 50, 3
"""Trials from which on copies are mentioned, and trials per different sequence; ours, chosen by eye."""


def of_trials(share: Proportion) -> str:
    """A share as a count and in per cent."""
    return f"{share.count} of {share.n} trials ({percent(share.value)})"


def broke_said(share: Proportion) -> str:
    """What is known of the success of trials some of which broke; empty if none did.

    >>> broke_said(Proportion(count=6, n=6, value=1.0, low=0.095, high=1.0, broken=24))
    '24 of 30 trials broke, 6 of the other 6 opened the box: between 20 % and 100 % [10 %, 100 %] would have.'
    """
    if not share.broken:
        return ""
    if not share.n:
        return f"All {share.broken} trials broke."
    least, most, low, high = (percent(one) for one in (*share.bounds, share.low, share.high))
    return (
        f"{share.broken} of {share.n + share.broken} trials broke, {share.count} of the other {share.n} opened the "
        f"box: between {least} and {most} [{low}, {high}] would have."
    )


def finding(agent: AgentSummary) -> str:
    """The effect of false reports on one agent's success, after a warning where broken trials select."""
    counted = [condition for condition in agent.conditions if condition.success.n]
    if not counted:
        return f"No trial of {subject_of(agent).name} has ended as solved or out of budget."
    if agent.blind:
        solved = f"it solved {of_trials(counted[0].success)} {at_dose(counted[0].dose, agent.axis)}"
        same = f"the results of these trials are the same at every other {agent.axis.name}"
        return f"{alike_said(agent)}: {solved}, and {same}."
    if agent.contrast is None:
        return _one_condition(agent, counted)
    copies = _copies_said(agent, counted[0])
    said = (_broken_said(agent), _contrast_said(agent, agent.contrast), idle_doses_said(agent), copies)
    return " ".join(filter(None, said))


def _copies_said(agent: AgentSummary, condition: ConditionSummary) -> str:
    """That most trials repeat others, as those of a deterministic agent that is told the truth."""
    n, different = condition.success.n, condition.distinct_sequences
    if n < _MANY or different * _COPIES > n:
        return ""
    where = capital(at_dose(condition.dose, agent.axis))
    return f"{where}, its {n} trials contain only {different} different sequences of actions."


def alike_said(agent: AgentSummary) -> str:
    """That an agent plays alike whatever it is told, and up to what share of reports it may still act on."""
    most = ceil(100 * (agent.heeded or 0.0))
    return f"{agent.name} played alike whatever it was told, so it acts on at most {most} % of reports"


def _one_condition(agent: AgentSummary, counted: list[ConditionSummary]) -> str:
    share = counted[0].success
    why = idle_doses_said(agent) or "No trial has been played under two conditions yet."
    if len(counted) == 1:
        single = agent.axis.name if agent.shown else "condition"
        why = f"With a single {single} there is no difference to test."
    said = f"{subject_of(agent).first} solved {of_trials(share)}, {interval(share.low, share.high)}."
    return " ".join(filter(None, (said, broke_said(share), why)))


def _contrast_said(agent: AgentSummary, contrast: Contrast) -> str:
    """The clearest difference from the lowest flip rate, and whether it was detected."""
    found, who = contrast.difference, subject_of(agent)
    first, second = at_dose(contrast.baseline.dose, agent.axis), at_dose(contrast.other.dose, agent.axis)
    it = who.form("it", "they")
    sample = "" if contrast.whole else f", of the trials that {it} finished under both conditions"
    if contrast.detectable:
        verdict = "more" if found.value > 0 else "less"
        counts = f"{of_trials(found.second)} against {of_trials(found.first)}{sample}"
        kind = f"with {cause(agent.axis)} " if agent.axis.options else ""
        return (
            f"{who.first} solved the box {verdict} often {kind}{second} than {first}: {counts} ({_interval(contrast)})."
        )
    risen = any(t.question == "shape" and t.rejects for t in agent.inference.tests)
    subject = f"No effect of {cause(agent.axis)} on the success of {who.name} was detected"
    if risen:
        subject = (
            f"No change of the success of {who.name} was detected at a single {agent.axis.name}; "
            f"the course over all {'other ' * bool(agent.idle)}{agent.axis.plural} is tested below"
        )
    size = f", the {'largest' if contrast.farthest else 'clearest'} difference" if contrast.choices > 1 else ""
    return (
        f"{subject}: {it} solved {of_trials(found.first)} {first} and {of_trials(found.second)} {second}{sample}"
        f"{size} ({_interval(contrast)}). This does not show that there is no effect."
    )


def _interval(contrast: Contrast) -> str:
    """The difference, its interval, its P value, and what they are corrected for."""
    found = contrast.difference
    many = [f"selection among {contrast.choices} differences"] * (contrast.choices > 1)
    many += [f"{contrast.agents} agents"] * (contrast.agents > 1)
    chosen = f"; interval and P value corrected for {' and '.join(many)}" if many else ""
    test = "e-process" if found.course else "permutation test"
    said = f"{change(found.value, found.low, found.high)}; {test}, {p_value(found.p_value)}{chosen}"
    if found.bounds is None:
        return said
    least, most = map(points, found.bounds)
    return f"{said}; between {least} and {most} points whatever became of broken trials"


def _broken_said(agent: AgentSummary) -> str:
    """That broken trials select, where their share differs detectably between conditions."""
    broken = agent.inference.broken
    if broken is None or not broken.differ or broken.p_value is None:
        return ""
    shares = "; ".join(f"{share.count} of {share.n} {at_dose(p, agent.axis)}" for p, share in broken.at)
    return (
        f"Trials of {subject_of(agent).name} broke more often under some conditions than under others ({shares}; "
        f"permutation test, {p_value(broken.p_value)}), so the remaining trials are a selected sample. A difference "
        "counts as detected only if it holds whatever became of the broken trials."
    )
