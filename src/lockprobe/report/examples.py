"""Trials worth reading, step by step: one that was solved, the one that loops most, the one most misread."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lockprobe.analysis.behaviour import has_loop, loop_coverage
from lockprobe.analysis.loops import cover
from lockprobe.analysis.misinterpretation import claims
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.record import Trial
from lockprobe.report.described import filled

__all__ = ["ExampleStep", "ExampleTrial", "ToldTwice", "example", "examples", "loop_letters", "told_twice"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ExampleStep:
    """One step of a trial that the page shows."""

    step: int
    state: str
    joint: str
    chosen: str | None
    moved: bool
    told_moved: bool | None
    claimed: str | None
    misinterpreted: bool | None
    loop: str
    again: bool
    hypothesis: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ExampleTrial:
    """One trial, step by step, and why it is worth reading."""

    why: str
    key: str
    ending: str
    joints: Sequence[str]
    labels: Sequence[str]
    target: str
    steps: Sequence[ExampleStep]


@dataclass(frozen=True, slots=True, kw_only=True)
class ToldTwice:
    """Two trials of equal luck, one under true and one under false reports, and the step at which they part.

    Attributes:
        parted: The first step, from 1, whose action differs.
        truth: The trial under true reports.
        lie: The trial under false reports.
    """

    parted: int
    truth: ExampleTrial
    lie: ExampleTrial


def told_twice(truth: Sequence[Trial], lie: Sequence[Trial], *, rises: bool) -> ToldTwice | None:
    """The first trial that only one of two conditions solved.

    Args:
        truth: Trials under true reports.
        lie: Trials of equal luck under false reports.
        rises: Whether the condition with false reports is to be the one that solved it.

    Returns:
        None where there is no such trial.
    """
    others = {(trial.repetition, trial.trial): trial for trial in lie}
    for one in truth:
        other = others.get((one.repetition, one.trial))
        if other is None or "error" in (one.ending, other.ending) or (one.solved, other.solved) != (not rises, rises):
            continue
        same = [a == b for a, b in zip(one.actions, other.actions, strict=False)]
        parted = (same.index(False) if False in same else len(same)) + 1
        return ToldTwice(
            parted=parted, truth=example("Under true reports", one), lie=example("Under false reports", other)
        )
    return None


def examples(summary: StudySummary, trials: Sequence[Trial]) -> list[ExampleTrial]:
    """Examples of the first agent that the study is about, each trial once."""
    if not summary.subjects:
        return []
    agent = summary.subjects[0]
    own = [t for t in trials if (t.group, t.modality) == (agent.agent, agent.modality) and t.ending != "error"]
    solved = [trial for trial in own if trial.solved]
    looping = sorted((trial for trial in own if has_loop(trial)), key=loop_coverage, reverse=True)
    misread = {trial.key: sum(claim.misinterpreted for claim in claims(trial)) for trial in own}
    wrong = sorted((trial for trial in own if misread[trial.key]), key=lambda t: misread[t.key], reverse=True)
    chosen: dict[str, ExampleTrial] = {}
    for why, candidates in (
        ("Solved", _farthest_first(solved, agent)),
        ("Looping: the largest share of steps in action loops", looping),
        ("Most misinterpretations", wrong),
    ):
        for trial in (candidate for candidate in candidates[:1] if candidate.key not in chosen):
            chosen[trial.key] = example(why, trial)
    return list(chosen.values())


def _farthest_first(trials: list[Trial], agent: AgentSummary) -> list[Trial]:
    """Trials of the condition that stands out, before the others."""
    p = agent.contrast.other.p if agent.contrast else 0.0
    return sorted(trials, key=lambda trial: trial.p != p)


def example(why: str, trial: Trial) -> ExampleTrial:
    """One trial, step by step, and why it is worth reading."""
    return filled(ExampleTrial, trial, why=why, steps=_steps(trial))


def _steps(trial: Trial) -> list[ExampleStep]:
    said = {claim.step: claim for claim in claims(trial)}
    loops = loop_letters(trial.actions)
    tried: set[tuple[str, str]] = set()
    lines = []
    for i, step in enumerate(trial.steps):
        claim = said.get(step.step)
        lines.append(
            filled(
                ExampleStep,
                step,
                claimed=claim.claimed if claim else None,
                misinterpreted=claim.misinterpreted if claim else False if trial.assessment else None,
                loop=loops[i].strip(),
                again=(step.state, step.joint) in tried,
                hypothesis=step.decision.hypothesis,
            )
        )
        tried.add((step.state, step.joint))
    return lines


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
