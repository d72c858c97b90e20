"""What false reports did to an agent's success, in plain words, with no more than the numbers bear."""

from __future__ import annotations

from lockprobe.analysis.condition import ConditionSummary, Contrast
from lockprobe.analysis.speaking import begun, of_trials, p_said, percent, points_said, told, verb
from lockprobe.analysis.summary import AgentSummary

__all__ = ["finding"]


def finding(agent: AgentSummary) -> str:
    """What false reports did to one agent's success; where broken trials select, that comes first."""
    counted = [condition for condition in agent.conditions if condition.success.n]
    if not counted:
        return f"No trial of {agent.called} has ended as solved or out of budget."
    if agent.blind:
        return _blind_said(agent, counted)
    if agent.contrast is None:
        return _one_condition(agent, counted)
    return " ".join(filter(None, (_broken_said(agent), begun(_contrast_said(agent, agent.contrast)))))


def _blind_said(agent: AgentSummary, counted: list[ConditionSummary]) -> str:
    first = counted[0]
    said = f"{agent.called} acted the same whatever it was told: it solved {of_trials(first.success)}"
    if all(condition.success.n == first.success.n for condition in counted):
        return f"{said} under every condition."
    return f"{said} {told(first.p)}, and ended each of them alike under every other condition in which it has it."


def _one_condition(agent: AgentSummary, counted: list[ConditionSummary]) -> str:
    share = counted[0].success
    why = "No trial has been played under two conditions yet."
    if len(counted) == 1:
        single = "flip rate" if agent.name != agent.agent else "condition"
        why = f"With a single {single} there is no difference to look for."
    interval = f"95 % interval {percent(share.low)} to {percent(share.high)}"
    return begun(f"{agent.called} solved {of_trials(share)}, {interval}. {why}")


def _contrast_said(agent: AgentSummary, contrast: Contrast) -> str:
    """The clearest difference from the lowest flip rate, and whether it is shown."""
    found, first, second = contrast.difference, told(contrast.baseline.p), told(contrast.other.p)
    it, its = verb(agent.agent, "it", "they"), verb(agent.agent, "its", "their")
    counts = f"{of_trials(found.second)} against {of_trials(found.first)}"
    sample = "" if contrast.whole else f", of the trials that {it} finished under both conditions"
    if contrast.detectable:
        verdict = "more" if found.value > 0 else "less"
        return (
            f"{agent.called} solved the box {verdict} often {second} than {first}: "
            f"{counts}{sample} ({_interval(contrast)})."
        )
    risen = any(t.question == "shape" and t.recommended and t.rejects for t in agent.inference.tests)
    subject = f"No effect of false reports on the success of {agent.called} is detectable"
    if risen:
        subject = (
            f"No single flip rate is shown to change the success of {agent.called}; for the course over all flip rates "
            "see below"
        )
    if not any(one.value for one in agent.inference.difference.at):
        share = found.first
        interval = f"95 % interval {percent(share.low)} to {percent(share.high)}"
        if contrast.whole:
            return (
                f"{subject}: {it} solved {percent(share.value)} of {its} trials under every condition "
                f"(n = {share.n} {first}, {interval})."
            )
        return f"{subject}: of the trials that {it} finished under both conditions {it} solved equally many, {counts}."
    size = "the largest difference" if contrast.farthest else "the clearest difference"
    return (
        f"{subject}: {it} solved {of_trials(found.first)} {first} and {of_trials(found.second)} {second}{sample}, "
        f"{size} ({_interval(contrast)}). That is not evidence that {'none does' if risen else 'there is none'}."
    )


def _interval(contrast: Contrast) -> str:
    """The difference, its interval, its P value, and what they are corrected for."""
    found = contrast.difference
    chosen = "" if contrast.choices == 1 else f", both corrected for choosing it from {contrast.choices}"
    said = (
        f"{points_said(found.value)} points, 95 % interval {points_said(found.low)} to {points_said(found.high)}; "
        f"permutation test and interval, {p_said(found.p_value)}{chosen}"
    )
    if found.if_unsolved is None or found.if_solved is None:
        return said
    return (
        f"{said}; with broken trials counted as unsolved {points_said(found.if_unsolved.value)} points, as solved "
        f"{points_said(found.if_solved.value)}, of which the p-value is the largest"
    )


def _broken_said(agent: AgentSummary) -> str:
    """That broken trials select, where their share is shown to differ between conditions."""
    broken = agent.inference.broken
    if broken is None or not broken.differ or broken.p_value is None:
        return ""
    shares = "; ".join(f"{share.count} of {share.n} {told(p)}" for p, share in broken.at)
    return (
        f"Trials of {agent.called} broke under some conditions more often than under others ({shares}; permutation "
        f"test, {p_said(broken.p_value)}), so that those that remain are a selection. A difference is concluded only "
        "if it holds with all broken trials counted as unsolved, and with all counted as solved."
    )
