"""The rule of the study of controls: the total first, then claims that need all of their contrasts; arms by what acts."""

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from builders import play_study
from hypothesis import given, settings
from hypothesis import strategies as st
from solved import columns

from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import read_condition
from lockprobe.statistics.course import cells_of
from lockprobe.statistics.design import ARMS, PLANNED, SeriesArm, arms_of
from lockprobe.statistics.outcomes import BlockOrder
from lockprobe.statistics.why import CONTRASTS, whys
from lockprobe.statistics.why import decide as decide_groups
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.study import design_of

LOW, HIGH = 0.23, 0.67
"""Success at the size of the paper's effect."""

PATTERNS = {
    "last": ("truth-lie", "lie-lie"),
    "first": ("lie-truth", "lie-lie"),
    "agreed": ("lie-lie",),
    "contradiction": ("lie-truth", "truth-lie", "lie-lie"),
    "form": ("truth-truth", "lie-truth", "truth-lie", "lie-lie", "remark"),
}
"""Claim -> the arms with which success is high, as with false reports, if it is true."""


def decide(solved, agents=1, planned=False):
    """What arms decide."""
    order = BlockOrder(plans=((1, len(solved["truth"])),)) if planned else None
    groups = {}
    for arm, own in solved.items():
        played = ~np.isnan(own)
        groups[arm] = replace(columns(own, np.arange(len(own)) + 1, solved=own > 0).at(played), order=order)
    return decide_groups(groups, agents=agents)


def drawn(high, rng, blocks=50, low=LOW, top=HIGH):
    """A study of independent arms."""
    return {arm: (rng.random(blocks) < (top if arm in ("lie", *high) else low)).astype(float) for arm in ARMS}


STUDIES = 30
"""A rate of 5 % is told from one of 20 % by so many: more than :func:`most` has a probability of .99 then."""


def studies(high, **more):
    rng = np.random.default_rng(1)
    return [decide(drawn(high, rng, **more)) for _ in range(STUDIES)]


def most(rate, n=STUDIES):
    """The most of so many studies at a rate, with three standard errors."""
    return n * (rate + 3 * math.sqrt(rate * (1 - rate) / n))


def exact(shares, blocks=200):
    """Arms with exactly these shares in equal luck."""
    return {arm: (np.arange(blocks) < share * blocks).astype(float) for arm, share in zip(ARMS, shares, strict=False)}


@pytest.mark.parametrize("claim", PATTERNS)
def test_a_mechanism_of_the_papers_size_is_found_in_50_blocks_and_a_wrong_one_seldom(claim):
    found = studies(PATTERNS[claim])
    coarse = "form" if claim == "form" else "says"
    assert sum(one.verdict == coarse for one in found) >= 0.85 * STUDIES
    false = "says" if claim == "form" else "form"
    assert sum(one.verdict in (false, "both", "no change") for one in found) <= most(0.05)
    described = Counter(one.claims for one in found)
    assert described.most_common(1)[0][0] == (claim,)


@pytest.mark.parametrize(
    ("shares", "verdict", "claims"),
    [
        ([0.1, 0.6, 0.1, 0.1, 0.1, 0.7, 0.1], "says", ("agreed",)),
        ([0.1, 0.6, 0.5, 0.1, 0.3, 0.7, 0.1], "says", ("falsity",)),  # a true correction does it too
        ([0.1, 0.6, 0.1, 0.2, 0.2, 0.6, 0.1], "says", ("last", "first")),  # one lie does it too
        ([0.1, 0.7, 0.1, 0.4, 0.4, 0.7, 0.1], "says", ("last", "first")),
        ([0.2, 0.6, 0.4, 0.4, 0.6, 0.6, 0.4], "both", ("last", "form")),
        ([0.2, 0.6, 0.6, 0.6, 0.6, 0.6, 0.6], "form", ("form",)),
        ([0.2, 0.6, 0.6, 0.6, 0.6, 0.6], "blurred", ()),  # without the remark nothing is claimed on the form
        ([0.9, 0.5, 0.9, 0.9, 0.5, 0.5, 0.9], "says", ("last",)),  # lies that lower success
        ([0.9, 0.5, 0.5, 0.5, 0.9, 0.9, 0.9], "blurred", ()),
    ],
)
def test_a_claim_is_made_of_what_other_reports_do_not_do_as_well(shares, verdict, claims):
    found = decide(exact(shares))
    assert (found.verdict, found.claims) == (verdict, claims)
    assert found.total.value == pytest.approx(shares[1] - shares[0])


def test_an_interaction_is_of_blocks_that_have_all_four_arms():
    """Else trials that are missing in one arm alone would make it an effect of the first statement."""
    arms = exact([0.2, 0.6, 0.2, 0.6, 0.2, 0.6, 0.2])
    assert decide(arms).contrasts["interaction"].value == 0
    missing = np.where(np.arange(200) % 2, math.nan, arms["truth-lie"])
    found = decide(arms | {"truth-lie": missing})
    assert (found.contrasts["interaction"].value, found.contrasts["interaction"].clusters) == (0, 100)
    assert found.claims == ("first",)


@pytest.mark.parametrize("share", [0.03, 0.45, 0.97])
def test_where_nothing_differs_no_part_is_computed_and_an_effect_is_seldom_said(share):
    found = studies((), low=share, top=share)
    detected = [one for one in found if one.contrasts]
    assert len(detected) <= most(0.05)
    for one in found:
        assert bool(one.contrasts) == (one.verdict not in ("no change", "inconclusive"))
        assert not one.claims or one.contrasts


@settings(max_examples=20, deadline=None)
@given(
    st.lists(st.tuples(*[st.booleans()] * len(ARMS)), min_size=4, max_size=40),
    st.permutations(range(len(ARMS))),
    st.integers(1, 5),
)
def test_contrasts_are_means_of_pairs_and_more_agents_only_detect_less(blocks, order, agents):
    arms = {arm: np.array([block[i] for block in blocks], float) for i, arm in enumerate(ARMS)}
    found = decide({list(ARMS)[i]: arms[list(ARMS)[i]] for i in order})
    for name, mean in found.contrasts.items():
        more, less = (np.mean([arms[arm] for arm in side]) for side in (CONTRASTS[name].of, CONTRASTS[name].minus))
        assert mean.value == pytest.approx(more - less, abs=1e-12)
    assert found == decide(arms)
    many = decide(arms, agents=agents)
    assert set(many.claims) - {"falsity"} <= set(found.claims)
    assert not (many.contrasts and not found.contrasts)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("low", "high", "shared", "false"),
    [(0.45, 0.45, False, {"says", "form", "both", "blurred", "not decided"}), (0.45, 0.55, True, {"no change"})],
    ids=["no change", "a change of the margin"],
)
def test_of_ten_agents_some_verdict_is_false_in_at_most_5_percent_of_studies(low, high, shared, false):
    """In 200 studies of 60 blocks, with three standard errors; each agent by itself errs in up to a third of them."""
    rng = np.random.default_rng(1)
    wrong = 0
    for _ in range(200):
        for _ in range(10):
            numbers = rng.random((1 if shared else len(ARMS), 60))
            share = {arm: high if arm == "lie" else low for arm in PLANNED}
            arms = {arm: (numbers[0 if shared else i] < share[arm]).astype(float) for i, arm in enumerate(PLANNED)}
            if decide(arms, agents=10).verdict in false:
                wrong += 1
                break
    assert wrong <= most(0.05, 200)


def test_at_every_look_the_same_mechanism_is_found_with_more_blocks():
    solved = drawn(PATTERNS["last"], np.random.default_rng(4), blocks=150)
    once, ever = decide(solved), decide(solved, planned=True)
    assert (once.verdict, once.claims) == (ever.verdict, ever.claims) == ("says", ("last",))
    assert ever.total.low < once.total.low < ever.total.value == once.total.value
    few = exact((0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0), blocks=12)
    assert decide(few).total.clear
    assert not decide(few, planned=True).total.clear


AGENT, BLOCKS = "cognitive:perseverant", 40


def as_arms(arms=ARMS, p=0.4, reading=""):
    """These arms at a rate, as an analysis sees them."""
    found = [read_condition(ARMS[arm].format(p=p, reading=reading), arm) for arm in arms]
    return [
        SeriesArm(
            label=one.label,
            specs=tuple(map(Spec.parse, one.specs)),
            doses=tuple(names for _, names in one.acting),
            modality=one.modality,
        )
        for one in found
    ]


@pytest.mark.parametrize("reading", ["", "&others=kept", "&inverts=position", "&inverts=position&others=kept"])
@pytest.mark.parametrize("p", [0.4, 1.0, 0.05])
def test_arms_are_known_by_what_acts_whatever_they_are_called(p, reading):
    renamed = [replace(one, label=f"condition {i}") for i, one in enumerate(as_arms(ARMS, p, reading))]
    assert arms_of(renamed[::-1]) == (p, {arm: f"condition {i}" for i, arm in enumerate(ARMS)})


def test_other_arms_may_be_missing_or_there_and_planned_ones_may_not():
    assert arms_of(as_arms(PLANNED)) == (0.4, {arm: arm for arm in PLANNED})
    for missing in PLANNED:
        assert arms_of(as_arms([arm for arm in ARMS if arm != missing])) is None
    rest = [arm for arm in ARMS if arm != "truth-lie"]
    assert arms_of([*as_arms(rest), *as_arms(["truth-lie"], 0.2)]) is None
    assert arms_of([*as_arms(rest), *as_arms(["truth-lie"], 0.4, "&others=kept")]) is None


def whys_of(trials, *agents):
    """What the agents of these trials show."""
    return tuple(whys(cells_of(trials), design_of(study("why", agent=list(agents), trials=BLOCKS))))


def played(*agents, trials=BLOCKS, **more):
    return play_study(study("why", agent=list(agents), trials=trials, repetitions=1, **more))


@pytest.fixture(scope="module")
def trials():
    return played(AGENT)


@pytest.fixture(scope="module")
def solved(trials):
    return {arm: np.array([one.solved for one in trials if one.condition == arm], float) for arm in ARMS}


def test_the_decision_is_that_of_the_outcomes_in_any_order(trials, solved):
    (found,), (again,) = whys_of(trials, AGENT), whys_of(trials[::-1], AGENT)
    assert (found[0], found[2], found[3]) == (AGENT, 0.4, {arm: arm for arm in ARMS})
    assert found[-1] == again[-1] == decide(solved)
    assert found[-1].claims == ("last",)


@pytest.mark.parametrize("missing", PLANNED)
def test_without_trials_in_a_planned_arm_there_is_no_answer(trials, missing):
    assert whys_of([one for one in trials if one.condition != missing], AGENT) == ()
