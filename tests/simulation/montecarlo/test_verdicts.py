"""Studies drawn from a pool conclude what whole studies conclude, and are held against what is true of each world."""

import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from lockprobe.agents.worlds import WORLDS
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec
from lockprobe.simulation.montecarlo.blocks import Played, played_blocks
from lockprobe.simulation.montecarlo.verdicts import (
    MECHANISMS,
    STATED,
    Mechanism,
    mechanism_of,
    stated_rates,
    verdict_rates,
)
from lockprobe.statistics.mechanism import MARGIN, decide
from lockprobe.statistics.series import SeriesArm
from lockprobe.statistics.why import why
from lockprobe.statistics.why_arms import ARMS
from lockprobe.studies.single import run_trial
from lockprobe.studies.studyfile import study


def test_the_pool_is_the_trials_of_a_study_and_its_verdict_that_of_the_report():
    planned = study("why", agent="world:loop-breaker", trials=20, repetitions=1, seed=5)
    arms = [one for one in planned.conditions if one.name in ARMS]
    trials = {
        one.name: [run_trial(agent="world:loop-breaker", condition=one, trial=i, seed=5) for i in range(1, 21)]
        for one in arms
    }
    (pool,) = played_blocks([Played(study=planned, agent="world:loop-breaker", conditions=tuple(arms))], 20)
    assert pool.tolist() == np.transpose([[trial.solved for trial in trials[one.name]] for one in arms]).tolist()
    found = why(
        trials,
        [SeriesArm(label=one.label, specs=tuple(map(Spec.parse, one.specs)), doses=one.dose_names) for one in arms],
    )
    names = [one.name for one in arms]
    assert decide(dict(zip(names, pool.T.astype(float), strict=True))) == found.decision


def test_nulls_are_told_and_counts_are_complete():
    (rates,) = verdict_rates(["world:lost-half"], blocks=[40], studies=7, pool=40)
    assert (rates.world, rates.truth, rates.change, rates.blocks) == ("world:lost-half", "no change", 0, 40)
    assert sum(rates.verdicts.values()) == 7
    assert (rates.right, rates.wrong) == (1, 0)


def test_a_few_studies_play_what_they_need_and_share_no_block():
    played = []
    rates = partial(verdict_rates, ["world:loop-breaker"], progress=lambda done, of: played.append(of))
    assert [one.blocks for one in rates(blocks=[8, 4], studies=2)] == [8, 4]
    assert played == [16]


@pytest.mark.parametrize(
    ("given", "said"), [({"pool": 10}, "pool"), ({"blocks": [1]}, "blocks"), ({"studies": 0}, "studies")]
)
def test_numbers_that_are_too_small_are_refused(given, said):
    with pytest.raises(BadValue, match=said):
        verdict_rates(["world:irrelevant"], **given)


def test_every_world_has_its_mechanism_and_the_exact_shares_of_its_arms_agree():
    page = (Path(__file__).parents[3] / "docs" / "agents.md").read_text("utf-8")
    assert set(MECHANISMS) == {f"world:{name}" for name in WORLDS}
    for name, numbers in re.findall(r"^\| `([a-z-]+)` \| [^|]+ ((?:\| [01]\.\d{3} ){7})\|$", page, re.MULTILINE):
        exact = [float(number) for number in re.findall(r"[01]\.\d{3}", numbers)]
        assert mechanism_of(exact).verdict == MECHANISMS[f"world:{name}"].verdict, name


@pytest.mark.parametrize(
    ("verdict", "acts", "total", "right", "wrong"),
    [
        ("says", ("says",), 0.3, {"says"}, {"form", "both", "no change"}),
        ("says", ("says",), -0.05, {"says", "no change"}, {"form", "both"}),
        ("both", ("says", "form"), 0.3, {"both"}, {"no change"}),
        ("blurred", ("says",), 0.3, {"blurred"}, {"form", "both", "no change"}),
        ("not decided", (), MARGIN, {"not decided"}, {"says", "form", "both", "no change"}),
        ("no change", (), 0, {"no change"}, {"says", "form", "both", "blurred", "not decided"}),
    ],
)
def test_what_is_right_and_what_is_wrong(verdict, acts, total, right, wrong):
    mechanism = Mechanism(verdict, acts)
    verdicts = ("says", "form", "both", "blurred", "not decided", "no change", "inconclusive")
    assert {one for one in verdicts if mechanism.right(one, total)} == right
    assert {one for one in verdicts if mechanism.wrong(one, total)} == wrong


@pytest.mark.parametrize(
    ("shares", "verdict"),
    [
        ((0.2, 0.7, 0.2, 0.7, 0.7, 0.7, 0.2), "says"),
        ((0.7, 0.2, 0.7, 0.7, 0.2, 0.2, 0.7), "says"),
        ((0.2, 0.7, 0.7, 0.7, 0.7, 0.7, 0.2), "blurred"),
        ((0.2, 0.7, 0.2, 0.2, 0.2, 0.2, 0.7), "not decided"),
        ((0.2, 0.7, 0.2, 0.7, 0.7, 0.2, 0.2), "not decided"),
        ((0.2, 0.7, 0.4, 0.4, 0.7, 0.7, 0.4), "both"),
        ((0.2, 0.7, 0.7, 0.4, 0.4, 0.7, 0.7), "form"),
        ((0.2, 0.2, 0.7, 0.4, 0.4, 0.7, 0.7), "no change"),
    ],
)
def test_what_is_true_of_stated_shares(shares, verdict):
    assert mechanism_of(shares).verdict == verdict


def test_stated_effects_are_told_and_chance_errors_keep_to_their_level():
    """With arms that share no luck the verdict errs in at most 5 % of studies, three standard errors aside."""
    for name, shares in STATED.items():
        small, large = stated_rates(name, shares, blocks=[20, 400], studies=60)
        assert max(small.wrong, large.wrong) <= 0.05 + 3 * (0.05 * 0.95 / 60) ** 0.5
        assert small.change == shares[1] - shares[0]
        if small.truth != "no change":
            assert large.right > 0.85
            assert large.claims


@pytest.mark.parametrize(("shares", "blocks"), [((0.2, 0.5), [50]), ((0.2,) * 6 + (1.5,), [50]), ((0.2,) * 7, [1])])
def test_effects_that_are_none_are_refused(shares, blocks):
    with pytest.raises(BadValue):
        stated_rates("x", shares, blocks=blocks)
