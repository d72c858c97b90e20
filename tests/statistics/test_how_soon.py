"""How soon: incidence by step, log-rank tests and mean steps, against the library, by hand, and of the right size."""

import numpy as np
import pytest
from builders import SOLUTION, make_trial
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from solved import columns

from lockprobe.statistics.course import cells_of, courses
from lockprobe.statistics.how_soon import (
    incidence,
    log_rank,
    looping,
    modality_effects,
    steps_over_doses,
    success_curve,
)
from lockprobe.statistics.modalities import by_fidelity, spoken
from lockprobe.statistics.outcomes import outcomes
from lockprobe.statistics.proportions import proportion

BUDGET = 20


def curve_of(trials):
    return success_curve(outcomes(trials))


def solved_at(steps, *, n, budget=20):
    """Trials solved at these steps, and others that are not, n in all."""
    waits = [make_trial([0] * (step - 4) + list(SOLUTION), budget=budget) for step in steps]
    return waits + [make_trial([0] * budget, budget=budget)] * (n - len(steps))


def test_a_step_lies_in_its_interval_which_is_open_where_the_band_does_not_reach_the_share():
    curve = curve_of(solved_at(range(4, 20), n=20))
    step, early, late = curve.steps_to(0.5)
    assert early <= step <= late
    assert curve.high[early - 1] < 0.5 <= curve.high[early]
    assert curve.low[late - 1] < 0.5 <= curve.low[late]
    assert curve.steps_to(0.8)[2] is None
    assert curve_of(solved_at([], n=30)).steps_to(0.5)[1:] == (None, None)


@pytest.mark.parametrize("seed", range(6))
def test_it_is_the_plain_share_without_early_censoring_and_the_librarys_with_it(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 98))
    steps, solved = rng.integers(1, 21, n), rng.random(n) < rng.choice([0.02, 0.5, 0.95])
    whole, censored = (incidence(one, solved, 20) for one in (np.where(solved, steps, 20), steps))
    for step in range(21):
        plain = proportion(int(np.sum(solved & (steps <= step))), n)
        assert whole.share[step] == plain.value
        assert (whole.low[step], whole.high[step]) == pytest.approx((plain.low, plain.high), abs=1e-9)
    library = stats.ecdf(stats.CensoredData.right_censored(steps, ~solved)).cdf
    assert censored.share == pytest.approx(library.evaluate(np.arange(21.0)).tolist(), abs=1e-12)
    low, share, high = map(np.array, (censored.low, censored.share, censored.high))
    assert np.all((low >= 0) & (low <= share) & (share <= high) & (high <= 1))


GROUP = st.lists(st.tuples(st.integers(1, 12), st.booleans()), min_size=1, max_size=15)


@given(GROUP, GROUP)
def test_the_ratio_is_observed_over_expected_events_of_the_second_over_the_first(first, other):
    last, happened = np.array([*first, *other]).T
    second, happened = np.repeat([False, True], [len(first), len(other)]), happened.astype(bool)
    expected = np.zeros(2)
    for step in range(1, last.max() + 1):
        running = last >= step
        share = np.sum(happened & (last == step)) / running.sum()
        expected += share * np.array([np.sum(running & ~second), np.sum(running & second)])
    events = np.array([np.sum(happened & ~second), np.sum(happened & second)])
    found = log_rank(last, happened, second, np.arange(len(last)))
    if events[0] and expected.min() > 1e-9:
        assert found.value == pytest.approx((events[1] / expected[1]) / (events[0] / expected[0]))
    if abs(events[1] - expected[1]) > 1e-9:
        assert found.direction == np.sign(events[1] - expected[1])


P = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6])


@pytest.mark.parametrize("clusters", [2, 6, 7, 19])
def test_a_test_that_could_never_reject_is_none(clusters):
    """However clear: all loop at once under noise, none ever without. The statistic never exceeds the clusters."""
    clear = [row for i in range(clusters) for row in ((0.0, i, 20, 0), *((p, i, 6, 6) for p in P[1:].tolist()))]
    p, trial, length, onset = zip(*clear, strict=True)
    found = looping(columns(p, trial, length=length, onset=onset))
    assert (found.p_value is None) == (clusters <= 6)
    assert found.p_value is None or found.p_value < 0.05
    assert found.direction == 1


def paired(*by_p, budget=BUDGET):
    """One row of steps for each p, trial by trial with the same luck."""
    n = len(by_p[0])
    p = np.repeat(np.arange(len(by_p)) / 10, n)
    return columns(p, np.tile(np.arange(1, n + 1), len(by_p)), length=np.concatenate(by_p), budget=budget)


@pytest.mark.parametrize("seed", range(4))
def test_it_is_students_paired_test_with_three_rare_blocks_in_the_variance(seed):
    rng = np.random.default_rng(seed)
    first, second, third = rng.integers([[4 + seed % 4], [4], [4]], BUDGET + 1, size=(3, 40))
    found, changes = steps_over_doses(paired(first, second, third)), (second + third) / 2 - first
    lowest, higher = first.mean(), (second + third).mean() / 2
    below, above = (
        np.hypot(stats.sem(changes), np.sqrt(3) * max(BUDGET - one, other - 4) / 40)
        for one, other in ((higher, lowest), (lowest, higher))
    )
    assert (found.value, found.n) == (pytest.approx(changes.mean()), 80)
    error = below if found.value > 0 else above
    assert found.p_value == pytest.approx(2 * stats.t.sf(abs(changes.mean()) / error, 39))
    reach = stats.t.ppf(0.975, 39)
    ends = changes.mean() - reach * below, changes.mean() + reach * above
    assert (found.low, found.high) == pytest.approx(ends)
    assert (found.p_value < 0.05) == (found.low > 0 or found.high < 0)


def over_doses(played):
    return steps_over_doses(outcomes(played))


def test_a_change_of_steps_holds_at_both_ends_of_what_broken_trials_can_have_become():
    quick = [make_trial(SOLUTION, trial=i) for i in range(30)]
    slow = [make_trial([0] * 10 + [*SOLUTION], p=0.4, trial=i) for i in range(30)]
    broke = [make_trial([0, 0], p=0.4, trial=i, broken="model") for i in range(30)]
    whole, few = (over_doses([*quick, *broke[:n], *slow[n:]]) for n in (0, 2))
    assert whole == steps_over_doses(outcomes([*quick, *slow]))
    assert (whole.value, few.value) == (10, 10)
    solved = [make_trial([0, *SOLUTION][-3:], p=0.4, trial=i) for i in range(2)]
    never = [make_trial([0] * 20, p=0.4, trial=i) for i in range(2)]
    ends = [steps_over_doses(outcomes([*quick, *gone, *slow[2:]])) for gone in (solved, never)]
    assert few.low == pytest.approx(min(one.low for one in ends))
    assert few.high == pytest.approx(max(one.high for one in ends))
    assert few.p_value == pytest.approx(max(one.p_value for one in ends))
    assert few.p_value < 0.05
    a_little = [make_trial([0] * 3 + [*SOLUTION], p=0.4, trial=i) for i in range(30)]
    assert over_doses([*quick, *broke[:23], *a_little[23:]]).p_value == 1.0  # those may have been solved at once
    assert over_doses([*quick, *broke]).p_value is None


# Modalities of one agent are compared from low to high fidelity, with trials that share their luck kept together.


def trials_of(modality, waits, agent="viewer"):
    """Trials that solve the box after so many wasted steps, or never."""
    return [
        make_trial([0] * (20 if wait is None else wait) + list(SOLUTION) * (wait is not None), agent=agent,
                   modality=modality, study="modalities", trial=i)
        for i, wait in enumerate(waits, 1)
    ]  # fmt: skip


def effects(*groups):
    return {
        one.agent: one
        for one in modality_effects(courses(cells_of([trial for group in groups for trial in group]).values()))
    }


def effect_of(**waits):
    """The effect on an agent that solves the box after these waits, by modality."""
    return effects(*(trials_of(modality, own) for modality, own in waits.items())).get("viewer")


SOON, MIDDLE, LATE = ([wait + i % 4 for i in range(10)] for wait in (0, 4, 8))


def test_the_papers_order_is_found_where_it_is():
    effect = effect_of(symbolic=LATE, rgb=SOON, rgbd=MIDDLE)
    assert effect.modalities == ("rgb", "rgbd", "symbolic")
    assert (effect.trend.direction, effect.trend.p_value < 0.05) == (-1, True)
    pairs = [("rgb", "rgbd"), ("rgb", "symbolic"), ("rgbd", "symbolic")]
    assert [both for *both, _, _, _ in effect.pairs] == [[*both] for both in pairs]
    assert all(hazard.value < 1 and gap.value == 0 and gap.first.n == 10 for *_, hazard, gap, _ in effect.pairs)
    assert all(steps.value > 0 for *_, steps in effect.pairs)
    alone = effect_of(symbolic=LATE, rgb=SOON).pairs[0][2].p_value
    assert alone < effect.pairs[1][2].p_value <= 3 * alone


def test_a_trend_that_broken_trials_may_have_made_is_none():
    """Half of the trials of the lowest fidelity broke in the second step, and may have been solved then, or never."""
    how = {"agent": "viewer", "modality": "rgb", "study": "modalities", "broken": "plant"}
    broken = [make_trial([0], trial=i, **how) for i in range(1, 11, 2)]
    whole, bounded = (
        effects(broken * broke + trials_of("rgb", MIDDLE)[broke :: 1 + broke], trials_of("symbolic", LATE))["viewer"]
        for broke in (False, True)
    )
    assert whole.trend.p_value < 0.05
    assert (bounded.trend.direction, bounded.trend.p_value, bounded.pairs[0][2].p_value) == (-1, 1.0, 1.0)


def test_modalities_are_named_and_ordered_as_in_the_paper():
    shown = ["symbolic", "rgbd?depth=gray&near=0.5", "symbolic?source=verdict", "rgb"]
    assert [spoken(one) for one in sorted(shown, key=by_fidelity)] == [
        "RGB", "RGB-D, depth=gray, near=0.5", "positions and outcomes in words", "verdicts of the arm",
    ]  # fmt: skip


def test_several_agents_are_one_family_and_baselines_another():
    def found(*agents):
        shown = (("rgb", SOON), ("symbolic", MIDDLE))
        return effects(*(trials_of(*one, agent=agent) for agent in agents for one in shown))

    (alone,), three = found("viewer").values(), found("viewer", "observer", "random")
    assert {agent: one.agents for agent, one in three.items()} == {"viewer": 2, "observer": 2, "random": 1}
    assert three["viewer"].trend.p_value == pytest.approx(min(1.0, 2 * alone.trend.p_value))
    assert three["viewer"].pairs[0][2].p_value == pytest.approx(min(1.0, 2 * alone.pairs[0][2].p_value))
    assert three["random"].trend.p_value == alone.trend.p_value
