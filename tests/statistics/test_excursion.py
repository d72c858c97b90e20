"""Effects of one false report: decision points as defined, estimates that agree with the exact effect."""

import numpy as np
import pytest
import scipy.stats

from lockprobe import population, run_trial
from lockprobe.simulation.exact.excursions import lie_effects
from lockprobe.statistics.excursion import (
    FEWEST,
    SOON,
    DecisionPoints,
    NotEstimated,
    decision_points,
    excursion,
    excursions,
)
from lockprobe.statistics.rationality import judge


@pytest.fixture(scope="module")
def trials():
    return [run_trial(agent="cognitive:insistent", p=0.4, trial=i) for i in range(1, 41)]


def test_every_report_after_which_a_trial_goes_on_is_a_point(trials):
    points = decision_points(trials)
    assert len(points) == sum(len(trial.steps) - 1 for trial in trials)
    assert points.cluster.max() + 1 == len(trials)
    assert set(points.p) == {0.4}
    solved = [trial.solved for trial in trials for _ in trial.steps[:-1]]
    assert points.outcomes["solved"].tolist() == solved


@pytest.mark.parametrize("modality", ["symbolic", "symbolic?tell=state"])
def test_the_coin_is_the_coin_whatever_the_agent_makes_of_the_report(modality):
    """The same coins fall for an agent that ignores reports, told outcomes or positions alone."""
    told = decision_points([run_trial(agent="random", p=0.4, trial=i, modality=modality) for i in range(1, 11)])
    plain = [run_trial(agent="random", p=0.4, trial=i, modality="symbolic") for i in range(1, 11)]
    assert told.flipped.tolist() == [step.told_falsely for trial in plain for step in trial.steps[:-1]]
    assert 0.2 < told.flipped.mean() < 0.6


def test_loops_and_what_leaves_them_are_as_defined(trials):
    points = decision_points(trials)
    at = 0
    for trial in trials:
        actions = trial.actions
        for i in range(len(actions) - 1):
            starts = [s for s in range(i - 4) if i >= 5 and actions[s : s + 3] == actions[i - 2 : i + 1]]
            assert points.looping[at] == bool(starts)
            if starts:
                assert points.outcomes["leaves"][at] == (actions[i + 1] != actions[starts[-1] + 3])
            else:
                assert np.isnan(points.outcomes["leaves"][at])
            assert points.outcomes["repeats"][at] == (actions[i + 1] == actions[i])
            soon = points.outcomes["soon"][at]
            assert np.isnan(soon) if i + 1 + SOON > 20 else soon == (trial.solved and len(actions) <= i + 1 + SOON)
            at += 1
    assert points.looping.any()


def test_an_action_is_optimal_if_an_observer_who_believes_what_was_told_finds_none_better(trials):
    points = decision_points(trials)
    judged = [step.optimal for trial in trials for step in judge(trial, prior="single-parent").steps[1:]]
    assert points.outcomes["optimal"].tolist() == judged
    assert 0 < np.mean(judged) < 1
    believer = [run_trial(agent="ideal-observer?noise=naive", p=0.4, trial=i) for i in range(1, 6)]
    assert decision_points(believer).outcomes["optimal"].min() == 1
    eight = decision_points([run_trial(agent="random", box="chain-8", p=0.4)])
    assert np.isnan(eight.outcomes["optimal"]).all()


def test_nothing_is_estimated_at_p_0_and_1_nor_of_few_trials(trials):
    for p in (0, 1):
        assert len(decision_points([run_trial(agent="random", p=p, trial=1)])) == 0
    assert excursions(decision_points([])).estimates == ()
    few = excursions(decision_points(trials[: FEWEST - 1]))
    assert few.estimates == ()
    assert {one.reason for one in few.left_out} == {f"fewer than {FEWEST} trials hold the outcome, or miss it"}


@pytest.mark.parametrize("carried", ["moved", "looping"])
def test_an_effect_is_left_out_with_its_reason_where_one_block_alone_carries_a_covariate(carried):
    """Without that block the design loses a column, and the block's residuals cannot be corrected."""
    rng, blocks, steps = np.random.default_rng(1), 40, 5
    cluster = np.repeat(np.arange(blocks), steps)
    flags = {name: rng.random(blocks * steps) < 0.5 for name in ("moved", "looping")}
    flags[carried] = (cluster == 7) & (np.tile(np.arange(steps), blocks) % 2 == 0)
    points = DecisionPoints(
        flipped=rng.random(blocks * steps) < 0.4,
        p=np.full(blocks * steps, 0.4),
        step=np.tile(np.arange(1.0, steps + 1), blocks),
        cluster=cluster,
        outcomes={"solved": (cluster % 2).astype(float)},
        **flags,
    )
    found = excursion(points, "solved", np.ones(blocks * steps, dtype=bool))
    assert found == NotEstimated(outcome="solved", among="all", reason="a covariate varies in one block alone")
    whole = excursion(points, "solved", cluster != 7)
    assert np.isfinite([whole.effect, whole.standard_error]).all()


def test_the_effects_of_several_agents_are_corrected_for_their_number(trials):
    alone = excursions(decision_points(trials))
    found = alone.corrected(4)
    assert alone.corrected(1) == alone
    assert found.agents == 4
    for one, among in zip(alone.estimates, found.estimates, strict=True):
        assert among.p_value == pytest.approx(min(1.0, 4 * one.p_value))
        reach = scipy.stats.t.ppf(1 - 0.05 / 8, one.freedom) * one.standard_error
        assert (among.low, among.high) == pytest.approx((max(-1, one.effect - reach), min(1, one.effect + reach)))


def test_shuffled_trials_give_the_same(trials):
    first, again = (excursions(decision_points(some)) for some in (trials, trials[::-1]))
    assert first.left_out == again.left_out
    assert [(one.outcome, one.effect) for one in first.estimates] == [
        (one.outcome, pytest.approx(one.effect)) for one in again.estimates
    ]


def of_population(made, p, rows):
    """The decision points of some trials of a population whose reports tell outcomes."""
    runs = np.arange(made.actions.shape[1])[None, :] < made.steps[rows][:, None] - 1
    trial, step = np.nonzero(runs)
    return DecisionPoints(
        flipped=(made.moved != made.told_moved)[rows][runs],
        p=np.full(len(trial), p),
        step=step + 1.0,
        moved=made.moved[rows][runs],
        looping=np.zeros(len(trial), dtype=bool),
        cluster=trial,
        outcomes={"solved": made.solved[rows][trial].astype(float)},
    )


@pytest.mark.parametrize(("agent", "p", "size"), [("cognitive:perseverant", 0.3, 100), ("random", 0.5, 100)])
def test_estimates_and_intervals_agree_with_the_exact_effect(agent, p, size):
    """The mean within 4 standard errors, coverage within 3 of 95 %, and standard errors within 4 of the spread."""
    exact, studies = lie_effects(agent, p=p, modality="symbolic").mean, 75
    made = population(agent, p=p, modality="symbolic", trials=studies * size, record=True, seed=2)
    found = []
    for first in range(0, studies * size, size):
        points = of_population(made, p, np.arange(first, first + size))
        found.append(excursion(points, "solved", np.ones(len(points), dtype=bool)))
    effects = np.array([one.effect for one in found])
    assert abs(effects.mean() - exact) < 4 * effects.std() / studies**0.5
    covered = np.mean([one.low <= exact <= one.high for one in found])
    assert covered > 0.95 - 3 * (0.95 * 0.05 / studies) ** 0.5
    assert np.mean([one.standard_error for one in found]) == pytest.approx(effects.std(), rel=4 / (2 * studies) ** 0.5)


def test_how_many_rows_are_squared_at_once_changes_no_estimate(trials, monkeypatch):
    points = decision_points(trials)
    at_once = excursions(points)
    monkeypatch.setattr("lockprobe.statistics.excursion._AT_ONCE", 10)
    assert excursions(points) == at_once
