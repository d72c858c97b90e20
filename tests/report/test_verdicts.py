"""Verdicts on the paper's claims for agents whose truth is known, most of them adversaries of a claim.

Every agent plays 30 trials on chain-4 at each p. Of an agent that differs from the paper's in one thing, the claims about
that thing must not come out compatible or borne out.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from builders import SOLUTION, make_trial, play_study, small_study

from lockprobe.report.claims.verdicts import claim_rows
from lockprobe.statistics.summary import summarise
from lockprobe.trial.record import Trial

PS = (0.0, 0.2, 0.4, 0.6)
ONCE = (0, 0, 0, 1, 0, 0, 2, 0, 1, 1, 0, 1, 2, 0, 2, 1, 0, 2, 2, 1)
"""Twenty blocked actions in which no three actions come twice."""
CYCLE = (0, 1, 2) * 7
LEFT = (0, 1, 2, 0, 1, 2, 2, 1, 0, 0, 2, 0, 0, 1, 1, 1, 0, 2, 2, 0)
"""A loop that is left at once."""


def agent(
    solved: Sequence[int],
    loops: Sequence[int] = (24, 20, 16, 20),
    *,
    p: Sequence[float] = PS,
    looping: Sequence[int] = CYCLE,
    misread: Sequence[int] = (),
    said: str = "moved",
    asked: bool = True,
) -> list[Trial]:
    """Trials of which so many of 30 are solved and so many loop at each p; a looping trial that is solved is so late.

    Args:
        solved: Solved trials at each p.
        loops: Trials with a loop at each p; unsolved trials first.
        looping: The actions of a trial with a loop.
        misread: Trials, from 0, in which one report of blocked (or, of moved, if ``said`` is blocked) is misread.
        said: What is said in a misreading.
        asked: Whether the agent says anything.
    """
    rng, made = np.random.default_rng(5), []
    for value, right, looped in zip(p, solved, loops, strict=True):
        place = rng.permutation(30)
        for rank in range(30):
            done, loop = rank < right, rank >= 30 - looped
            wait = 3 + rank % 4 if not loop else 12
            actions = [*(looping if loop else ONCE)[: wait if done else 20], *(SOLUTION if done else ())]
            trial = make_trial(
                actions, agent="llm:x", p=value, repetition=1 + place[rank] // 10, trial=1 + place[rank] % 10
            )
            told = ["moved" if step.moved else "blocked" for step in trial.steps[:-1]]
            if rank in misread:
                at = told.index("blocked" if said == "moved" else "moved")
                told[at] = said
            claimed = [None, *told] if asked else [None] * len(trial.steps)
            steps = [
                replace(step, decision=replace(step.decision, claimed=claim))
                for step, claim in zip(trial.steps, claimed, strict=True)
            ]
            made.append(replace(trial, steps=tuple(steps)))
    return made


def verdicts(trials: Sequence[Trial]) -> dict[str, str]:
    """The verdicts by measure."""
    rows = claim_rows(summarise(trials))
    return {claim.measure: found[1] for claim, _, found in rows if claim.modality == "symbolic"}


PAPER = (7, 14, 20, 10)
NOT_SHOWN = ("not compatible", "not decided", "not measured")
AGENTS = {
    "only falls": (partial(agent, (30, 28, 20, 8)), {"peak": 0, "ratio": 0, "effect": 0, "shape": None, "baseline": 0}),
    "falls a little first": (
        partial(agent, (30, 28, 20), (24, 16, 20), p=(0.0, 0.4, 0.6)),
        {"peak": 0, "effect": None},
    ),
    "flat": (partial(agent, (15,) * 4), {"peak": 0, "ratio": 0, "effect": None, "shape": None, "baseline": 1}),
    "only rises": (partial(agent, (4, 10, 16, 28)), {"peak": 0, "effect": 1, "shape": None}),
    "levels off": (partial(agent, (7, 15, 20, 20)), {"peak": 1, "ratio": 1, "effect": 1, "shape": None}),
    "never solves": (partial(agent, (0,) * 4), {"peak": 0, "ratio": None, "effect": None, "baseline": 0}),
    "few trials at once": (partial(agent, (7, 9, 10, 9)), {"peak": 0, "ratio": None, "effect": None, "shape": None}),
    "never misreads": (partial(agent, PAPER), {"misinterpretation": 0, "hallucination": 0}),
    "is not asked": (partial(agent, PAPER, asked=False), {"misinterpretation": "-", "hallucination": "-"}),
    "misses changes": (
        partial(agent, (15,) * 4, misread=range(15), said="blocked"),
        {"misinterpretation": 1, "hallucination": 0},
    ),
    "always loops": (
        partial(agent, (0,) * 4, (30,) * 4),
        {"loops": 0, "loops-drop": 0, "loops-rise": None, "onset": None},
    ),
    "never loops": (
        partial(agent, PAPER, (0,) * 4),
        {"loops": 0, "loops-drop": 0, "loops-rise": None, "onset": None},
    ),
    "loops at every p alike": (
        partial(agent, PAPER, (24,) * 4),
        {"loops": None, "loops-drop": None, "loops-rise": None, "onset": None},
    ),
    "loops more and more": (
        partial(agent, PAPER, (4, 12, 22, 28)),
        {"loops": 0, "loops-drop": 0, "loops-rise": 0, "onset": 0, "correlation": 0},
    ),
    "loops less and less": (
        partial(agent, PAPER, (28, 20, 12, 1)),
        {"loops": 1, "loops-drop": 0, "loops-rise": 0, "onset": 1, "correlation": None},
    ),
    "as the paper has it": (
        partial(agent, PAPER, (26, 18, 14, 26), looping=LEFT, misread=range(0, 30, 2)),
        {
            "baseline": 1,
            "peak": 1,
            "ratio": 1,
            "effect": 1,
            "shape": 1,
            "loops": 1,
            "loops-drop": 1,
            "loops-rise": 1,
            "misinterpretation": 1,
            "hallucination": 1,
        },
    ),
}
"""Agents, and what is expected: 1 compatible or borne out, 0 not compatible, None not decided, "-" not measured."""


@pytest.mark.parametrize("name", AGENTS)
def test_a_verdict_is_about_the_whole_claim(name):
    played, expected = AGENTS[name]
    said = {1: ("compatible", "borne out"), 0: ("not compatible",), None: ("not decided",), "-": ("not measured",)}
    found = verdicts(played())
    assert {measure: found[measure] for measure in expected if found[measure] not in said[expected[measure]]} == {}


def test_a_blind_agent_bears_out_nothing_about_p():
    found = verdicts(play_study(small_study(["random"], PS, 3, 10)))
    over_p = ("peak", "ratio", "effect", "shape", "loops", "loops-drop", "loops-rise", "onset", "correlation")
    assert {measure: found[measure] for measure in over_p if found[measure] not in NOT_SHOWN} == {}
