"""The claims of the paper: their figures, and verdicts on the whole of a claim, which follow from valid tests."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from builders import SOLUTION, make_trial, modality_study, small_study, write_study
from reported import found_in, tables_of

from lockprobe.report.questions.claims import judged, paper_claims
from lockprobe.report.results import results
from lockprobe.statistics.proportions import Z, difference, proportion
from lockprobe.statistics.published import CORRELATION, LOOPED, SOLVED, TABLE1
from lockprobe.studies.options.studyfile import study


def test_the_papers_figures_follow_from_its_counts():
    said = {claim.measure: claim.recomputed for claim in paper_claims() if claim.modality == "symbolic"}
    for measure, share in (
        ("reference", proportion(10, 10)), ("modalities", proportion(8, 10)), ("baseline", SOLVED[0]), ("peak", SOLVED[1]),
        ("loops", LOOPED[0]),
    ):  # fmt: skip
        counted = f"{share.count}/{share.n}, {share.value:.3f} [{share.low:.3f}, {share.high:.3f}]"
        assert said[measure].startswith(counted), measure
    effect = difference(*SOLVED)
    from statsmodels.stats.proportion import confint_proportions_2indep

    low, high = confint_proportions_2indep(20, 30, 7, 30, compare="ratio", method="score")
    assert f"P = {effect.p_value:.4f}, corrected for selection among six {6 * effect.p_value:.4f}" in said["effect"]
    assert said["ratio"].startswith(f"{20 / 7:.2f} [{low:.2f}, {high:.2f}]")
    assert said["modalities"].endswith(f"P = {difference(proportion(8, 10), proportion(10, 10)).p_value:.2f}")
    drop, relative = difference(*LOOPED), difference(proportion(23, 30), proportion(17, 30))
    assert f"P = {drop.p_value:.3f}" in said["loops-drop"]
    assert said["loops-drop"].endswith(f"P = {relative.p_value:.2f}")
    for n in (7, 21):
        low, high = (math.tanh(math.atanh(CORRELATION) + side * Z / math.sqrt(n - 3)) for side in (-1, 1))
        assert f"over {n} points [{low:.2f}, {high:.2f}]" in said["correlation"].replace("\N{MINUS SIGN}", "-")
    totals = {"rgb": 22, "rgbd": 35, "symbolic": 6}
    steps = {modality: round(total / TABLE1[modality][0]) for modality, total in totals.items()}
    assert (
        f"about {steps['rgb']} steps with RGB, {steps['rgbd']} with RGB-D and {steps['symbolic']} with ground truth"
        in said["modality-order"]
    )
    for claim in paper_claims():
        if claim.measure == "misinterpretation":
            (mean, sd, _), total = TABLE1[claim.modality], totals[claim.modality]
            assert claim.value.startswith(f"{100 * mean:.1f} % ± {100 * sd:.1f} %, {total} in all")
            assert claim.recomputed.startswith(f"{total} in about {steps[claim.modality]} steps")


def test_every_claim_has_its_place_in_the_table_and_an_empty_study_measures_none(tmp_path):
    planned = small_study(["human-inspired", "llm:x"])
    empty, *_ = [results(write_study(tmp_path / "empty", planned, []))]
    assert [row[1] for row in tables_of(empty)["claims"][1:]] == [claim.quote for claim in paper_claims()]
    assert {row[6] for row in tables_of(empty)["claims"][1:]} == {"not measured"}
    found = found_in(tmp_path, study("flips", agent=["mine=human-inspired"], p=[0, 0.3], trials=4, repetitions=2))
    rows = tables_of(found)["claims"][1:]
    assert list(dict.fromkeys(row[1] for row in rows)) == [claim.quote for claim in paper_claims()]
    assert {row[4] for row in rows} == {"", "mine"}  # the strategy is known by what it is, not by its name
    known = measured(found)
    assert known["reference-steps"][0] == "compatible"
    assert {"modalities", "peak"}.isdisjoint(known)  # one modality, and no flip rate of 0.4


def measured(found, modality="symbolic"):
    """Measure of a claim -> verdict and P value, of the only agent that speaks to it."""
    said = {one.measure: [*judged(found, one)] for one in paper_claims() if one.modality == modality}
    return {measure: (one.verdict, one.p_value) for measure, found in said.items() for one in found}


PS = (0.0, 0.2, 0.4, 0.6)
ONCE = (0, 0, 0, 1, 0, 0, 2, 0, 1, 1, 0, 1, 2, 0, 2, 1, 0, 2, 2, 1)
"""Twenty blocked actions in which no three actions come twice."""
CYCLE = (0, 1, 2) * 7
LEFT = (0, 1, 2, 0, 1, 2, 2, 1, 0, 0, 2, 0, 0, 1, 1, 1, 0, 2, 2, 0)
"""A loop that is left at once."""


def agent(solved, loops, *, p=PS, looping=CYCLE, misread=(), said="moved", asked=True):
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
        place = rng.permutation(30).tolist()
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


PAPER = (7, 14, 20, 10)
AGENTS = [  # solved and looping trials at each p, more of the agent, and what is expected
    ((30, 28, 20, 8), (), {}, "-peak -ratio -effect ?shape -baseline"),  # only falls
    ((15,) * 4, (), {}, "?peak -ratio ?effect ?shape +baseline"),
    ((4, 10, 16, 28), (), {}, "-peak +effect ?shape"),  # only rises
    ((7, 15, 20, 20), (), {}, "+peak +ratio +effect ?shape"),  # levels off
    (PAPER, (), {"asked": False}, " misinterpretation  hallucination"),
    ((15,) * 4, (), {"misread": range(15), "said": "blocked"}, "+misinterpretation -hallucination"),  # misses changes
    ((0,) * 4, (30,) * 4, {}, "?peak ?ratio ?effect -baseline -loops -loops-drop ?loops-rise ?onset"),
    (PAPER, (24,) * 4, {}, "?loops ?loops-drop ?loops-rise ?onset"),
    (PAPER, (4, 12, 22, 28), {}, "-loops -loops-drop ?loops-rise -onset -correlation"),
    (PAPER, (28, 20, 12, 1), {}, "+loops -loops-drop ?loops-rise +onset ?correlation"),
    (
        PAPER,
        (26, 18, 14, 26),
        {"looping": LEFT, "misread": range(0, 30, 2)},
        "+baseline +peak +ratio +effect +shape +loops +loops-drop +loops-rise +misinterpretation +hallucination",
    ),
]
SIGNS = {"compatible": "+", "borne out": "+", "not compatible": "-", "not decided": "?", "": " "}
"""A verdict -> its sign; a claim that is not measured has none."""


@pytest.mark.parametrize(("solved", "loops", "more", "expected"), AGENTS)
def test_a_verdict_is_about_the_whole_claim(tmp_path, solved, loops, more, expected):
    trials = agent(solved, loops or (24, 20, 16, 20), **more)
    rates = sorted({trial.p for trial in trials})
    known = measured(found_in(tmp_path, small_study(["llm:x"], rates, 3, 10), trials))
    measures = re.findall(r"[\w-]+\b", re.sub(r"(^| )[-+?]", " ", expected))
    assert " ".join(SIGNS[known.get(one, ("",))[0]] + one for one in measures) == expected


THREE = ("modality-order", "modality-outpaces", "modality-steps")
ORDERS = [  # which modality is taken for which, and the signs of the three claims
    ({}, "+++"),
    ({"rgb": "symbolic", "symbolic": "rgb"}, "---"),
    ({"rgbd": "symbolic", "symbolic": "rgbd"}, "--"),  # the trend alone would bear the order out
]


def again(trial, modality):
    """The trial as one of another modality."""
    key = trial.key.replace(f"/{trial.condition}/", f"/{modality}/")
    return replace(trial, key=key, modality=modality, condition=modality)


@pytest.mark.parametrize(("turned", "signs"), ORDERS)
def test_the_order_of_three_modalities(tmp_path, modal, turned, signs):
    trials = [again(one, turned.get(one.modality, one.modality)) if one.agent == "viewer" else one for one in modal]
    found = found_in(tmp_path, modality_study(), trials)
    known = measured(found)
    assert "".join(SIGNS[known[measure][0]] for measure in THREE).startswith(signs)
    assert known["modality-order"][1] < 0.05
    (here,) = (said for one in paper_claims() if one.measure == "modality-order" for said in judged(found, one))
    assert (here.agent, here.here.startswith("mean steps ")) == ("viewer", True)
    assert measured(found, "rgb").keys() == measured(found, "rgbd").keys() == {"misinterpretation"}
