"""Trials worth reading, step by step: one that was solved, the one that loops most, the one most misread."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from lockprobe.report.rows import Exhibit, ExhibitStep
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.behaviour import has_loop, loop_coverage
from lockprobe.statistics.loops import cover
from lockprobe.statistics.misinterpretation import claims
from lockprobe.statistics.summary import StudySummary
from lockprobe.trial.record import Trial


def examples(summary: StudySummary, trials: Sequence[Trial]) -> list[Exhibit]:
    """Examples of the first agent that the study is about, each trial once."""
    if not summary.subjects:
        return []
    agent = summary.subjects[0]
    own = [t for t in trials if (t.group, t.modality) == (agent.agent, agent.modality) and t.ending != "error"]
    solved = [trial for trial in own if trial.solved]
    looping = sorted((trial for trial in own if has_loop(trial)), key=loop_coverage, reverse=True)
    misread = {trial.key: sum(claim.misinterpreted for claim in claims(trial)) for trial in own}
    wrong = sorted((trial for trial in own if misread[trial.key]), key=lambda t: misread[t.key], reverse=True)
    chosen: dict[str, Exhibit] = {}
    for why, candidates in (
        ("Solved", _farthest_first(solved, agent)),
        ("Looping: the largest share of steps in action loops", looping),
        ("Most misinterpretations", wrong),
    ):
        for trial in (candidate for candidate in candidates[:1] if candidate.key not in chosen):
            shown = f" ({agent.shown})" if agent.shown else ""
            chosen[trial.key] = exhibit("trials", f"{why}{shown}", trial)
    return list(chosen.values())


def _farthest_first(trials: list[Trial], agent: AgentSummary) -> list[Trial]:
    """Trials of the condition that stands out, before the others."""
    p = agent.contrast.other.dose if agent.contrast else 0.0
    return sorted(trials, key=lambda trial: trial.p != p)


def exhibit(section: str, why: str, trial: Trial, *, words: bool = False, **more: Any) -> Exhibit:
    """One trial, step by step.

    Args:
        section: The section of the report that shows it.
        why: Why it is worth reading.
        trial: One that ended as solved or out of budget.
        words: Whether its steps have the words of their reports, with the remark that came with each.
        more: Further fields, such as the step at which it parts from another trial.
    """
    shown = {name: getattr(trial, name) for name in ("key", "ending", "joints", "labels", "target")}
    return Exhibit(
        section=section, agent=trial.group, why=why, **shown, steps=tuple(_steps(trial, words=words)), **more
    )


def _steps(trial: Trial, *, words: bool) -> Iterator[ExhibitStep]:
    said = {claim.step: claim for claim in claims(trial)}
    loops = loop_letters(trial.actions)
    tried: set[tuple[str, str]] = set()
    remarks = [*(step.remark for step in trial.steps[1:]), ""]
    for step, letter, remark in zip(trial.steps, loops, remarks, strict=True):
        claim = said.get(step.step)
        yield ExhibitStep(
            **{name: getattr(step, name) for name in ("step", "state", "joint", "chosen", "moved", "told_moved")},
            claimed=claim.claimed if claim else None,
            misinterpreted=claim.misinterpreted if claim else False if trial.assessment else None,
            loop=letter.strip(),
            again=(step.state, step.joint) in tried,
            hypothesis=step.decision.hypothesis,
            words=f"{step.told} {remark}".strip() if words else "",
        )
        tried.add((step.state, step.joint))


def loop_letters(actions: tuple[str, ...]) -> str:
    """A character for each step: within an action loop the letter of what is repeated, elsewhere a blank.

    >>> loop_letters(tuple("ABCABCABCD"))
    'aaaaaaaaa '
    """
    marks, letters = [" "] * len(actions), dict[tuple[str, ...], str]()
    for start, length in cover(actions).intervals:
        letter = letters.setdefault(actions[start : start + length], "abcdefghijklmnopqrstuvwxyz"[len(letters) % 26])
        marks[start : start + length] = letter * length
    return "".join(marks)
