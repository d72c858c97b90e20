"""The claims of the paper: their figures, verdicts that follow from tests, and the page that says them."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from builders import SOLUTION, make_trial, modality_study, play_study, small_study
from clumsy import CLUMSY
from known_truth import records
from reported import found_in

from lockprobe.foundation.seeds import generator
from lockprobe.report.claims.claim_tests import pattern, verdict_of
from lockprobe.report.claims.paper import CLAIMS, fisher_z
from lockprobe.report.claims.verdicts import claim_rows
from lockprobe.report.page import page_of, tables_of
from lockprobe.statistics.published import CORRELATION
from lockprobe.statistics.summary import summarise
from lockprobe.studies.options.studyfile import study
from lockprobe.trial.record import Trial


def test_a_verdict_needs_the_figure_and_the_pattern():
    assert [verdict_of(0.5, also) for also in ("shown", "open", "opposite")] == [
        "compatible", "not decided", "not compatible",
    ]  # fmt: skip
    assert [verdict_of(0.01, also) for also in ("shown", "open", "opposite")] == ["not compatible"] * 3


@pytest.mark.parametrize(
    ("p_value", "direction", "expected"),
    [(0.04, 1, "shown"), (0.04, -1, "opposite"), (0.05, 1, "open"), (None, 1, "open"), (0.01, 0, "open")],
)
def test_a_pattern_is_shown_by_a_test_that_rejects_in_its_direction(p_value, direction, expected):
    assert pattern(p_value, direction) == expected


def rows_of(world, seed=1):
    return by_measure(summarise([replace(trial, agent="llm:x") for trial in records(world, generator(seed))]))


def by_measure(summary):
    """Measure of a claim -> its verdict and P value, for an agent that speaks to it."""
    return {claim.measure: (verdict, p) for claim, _, (_, verdict, _, p) in claim_rows(summary)}


def test_the_papers_figures_follow_from_its_counts():
    said = {claim.measure: claim.recomputed for claim in CLAIMS}
    assert said["baseline"].startswith("7/30, 0.233 [0.118, 0.409]")
    assert said["peak"].startswith("20/30, 0.667 [0.488, 0.808]")
    assert said["ratio"].startswith("2.86 [1.50, 5.90]")
    assert "Fisher P = 0.0016, corrected for selection among six 0.0096" in said["effect"]
    assert said["loops-drop"] == "in points 24/30 to 16/30, Fisher P = 0.054; relative 23/30 to 17/30, P = 0.17"
    modalities = [claim.recomputed for claim in CLAIMS if claim.measure == "modalities"]
    assert modalities[0] == "8/10, 0.800 [0.490, 0.943]; Fisher against 10/10: P = 0.47"


def test_the_interval_of_the_papers_correlation():
    assert fisher_z(CORRELATION, 7) == pytest.approx((-0.95, 0.13), abs=0.005)
    assert fisher_z(CORRELATION, 21) == pytest.approx((-0.86, -0.37), abs=0.005)


def test_table_1_implies_more_steps_with_rgbd_than_with_ground_truth():
    (order,) = (claim.recomputed for claim in CLAIMS if claim.measure == "modality-order")
    assert "about 101 steps with RGB, 131 with RGB-D and 122 with ground truth" in order
    assert "35 in 122 steps are 28.7 %, the mean is 26.8 %" in order


def test_every_claim_is_there_in_the_order_of_the_paper():
    rows = claim_rows(summarise(play_study(small_study())))
    assert list(dict.fromkeys(claim for claim, *_ in rows)) == list(CLAIMS)
    assert {agent for claim, agent, _ in rows if claim.measure == "reference"} == {"human-inspired"}
    assert claim_rows(summarise([]))
    assert {verdict for _, _, (_, verdict, *_) in claim_rows(summarise([]))} == {"not measured"}


def test_an_agent_like_the_papers_looks_like_it_and_supports_nothing_on_loops():
    """Loops are irrelevant in this world, and yet its figures are those of Fig. 5. A few verdicts err by chance."""
    studies = [rows_of("loops-irrelevant", seed) for seed in range(3)]
    for measure in ("baseline", "peak", "ratio", "correlation"):
        assert sum(rows[measure][0] == "compatible" for rows in studies) >= 2, measure
    for measure in ("loops", "loops-drop"):  # a drop such as the paper's is often not shown by 30 trials
        assert sum(rows[measure][0] in ("compatible", "not decided") for rows in studies) >= 2, measure
        assert sum(rows[measure][0] == "compatible" for rows in studies) >= 1, measure
    assert sum(rows["effect"][0] == "borne out" for rows in studies) >= 2
    assert sum(rows["onset"][0] == "borne out" for rows in studies) <= 1


def test_what_a_study_does_not_hold_is_not_measured():
    rows = by_measure(summarise(play_study(small_study(["human-inspired"]))))
    assert rows["modalities"][0] == "not measured"
    assert rows["peak"][0] == "not measured"  # no p of 0.4
    assert rows["reference-steps"][0] == "compatible"


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


def test_the_opposite_order_is_not_compatible(modal):
    turned = {"rgb": "symbolic", "symbolic": "rgb", "rgbd": "rgbd"}
    trials = [t if t.agent != "viewer" else replace(t, modality=turned[t.modality]) for t in modal]
    rows = by_measure(summarise(trials))
    assert rows["modality-order"][0] == "not compatible"
    assert rows["modality-order"][1] < 0.05
    assert rows["modality-outpaces"][0] == rows["modality-steps"][0] == "not compatible"


def test_rgbd_has_to_lie_in_between(modal):
    """The trend alone would bear the order out: RGB is fastest, RGB-D slowest, and ground truth just before it."""
    turned = {"rgb": "rgb", "rgbd": "symbolic", "symbolic": "rgbd"}
    trials = [t if t.agent != "viewer" else replace(t, modality=turned[t.modality]) for t in modal]
    rows = by_measure(summarise(trials))
    assert rows["modality-order"][1] < 0.05
    assert rows["modality-order"][0] == "not compatible"
    assert rows["modality-outpaces"][0] == "not compatible"


def test_two_modalities_do_not_decide_what_is_said_of_three(modal):
    trials = [t for t in modal if t.modality != "rgbd"]
    rows = by_measure(summarise(trials))
    assert rows["modality-order"][0] == rows["reference-faster"][0] == "not decided"
    assert rows["modalities"][0] in ("not decided", "not compatible")
    assert rows["modality-outpaces"][0] == "not measured"


def test_a_study_of_one_modality_says_nothing_of_modalities(modal):
    rows = claim_rows(summarise([trial for trial in modal if trial.modality == "symbolic"]))
    for claim, _, (_, verdict, *_) in rows:
        if claim.measure.startswith(("modalit", "reference-faster")) or claim.modality != "symbolic":
            assert verdict == "not measured"


def test_variants_of_one_modality_have_no_order_that_could_be_borne_out(modal):
    variants = {"rgb": "rgbd?depth=gray", "rgbd": "rgbd", "symbolic": "rgbd?depth=height"}
    trials = [replace(t, modality=variants[t.modality]) for t in modal if t.agent == "viewer"]
    rows = [found for claim, _, found in claim_rows(summarise(trials)) if claim.measure == "modality-order"]
    assert [verdict for _, verdict, *_ in rows] == ["not measured"]


def test_every_claim_of_the_section_on_modalities_is_measured(tmp_path, modal):
    modalities = found_in(tmp_path, modality_study(), modal)
    here = {row.of: row for row in modalities.where("claim", agent="viewer", modality="")}
    assert here["modality-order"].note == here["modality-outpaces"].note == "borne out"
    assert here["modality-order"].test == "log-rank test for a trend over fidelity, and the order of the mean steps"
    assert modalities.said("claims", "modality-order") == [
        "mean steps 5.9 with RGB, 9.9 with RGB-D, 13.9 with positions and outcomes in words"
    ]
    assert here["modality-steps"].note == "compatible"
    misread = [row for row in modalities.where("claim") if row.of.startswith("misinterpretation, ")]
    assert [modalities.label(row.agent, row.modality) for row in misread] == ["viewer (RGB)", "viewer (RGB-D)"]


def test_where_the_rules_were_broken_numbers_stay_and_no_claim_is_judged(tmp_path):
    planned = study("flips", agent=["cognitive:careful"], p=[0, 0.4], trials=6, repetitions=1, plant=CLUMSY)
    clumsy = found_in(tmp_path, planned)
    rows = clumsy.where("claim")
    assert clumsy.not_judged.startswith("No claim of the paper is judged: ")
    assert {(row.note, row.test) for row in rows} == {("not judged", clumsy.not_judged)}
    assert all(clumsy.said("claims", row.of) for row in rows)
    assert {row[6] for row in tables_of(clumsy)["claims"][1:]} == {"not judged", "not measured"}
    assert f"<p>{clumsy.not_judged}</p>" in page_of(clumsy)
