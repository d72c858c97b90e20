"""Tests of loops in time: against brute force and the library, of the right size when luck is shared, and strong."""

import numpy as np
import pytest
from scipy import stats
from statsmodels.duration.survfunc import survdiff
from statsmodels.stats.multitest import multipletests

from lockprobe.statistics.inference.excess import excess, grid
from lockprobe.statistics.inference.logrank import loop_onset_logrank
from lockprobe.statistics.loops import onset_batch
from lockprobe.statistics.outcomes import Outcomes

P = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
RISING = (0.23, 0.4, 0.53, 0.63, 0.67, 0.6, 0.5)
FLAT = (0.5,) * 7
NO_TRAP = (0.0,) * 7
TRAP = (0.4, 0.3, 0.2, 0.1, 0.05, 0.05, 0.05)
BUDGET = 20


def world(rng, success=RISING, trap=NO_TRAP, n=30, shared=0.0):
    """Actions without immediate repeats that may fall into a cycle of three; a clock that solves from step 4 on.

    The clock knows nothing of the actions. A ``shared`` part of the trials has the same luck at every p.
    """
    common, alike = rng.random((1, n, BUDGET, 3)), rng.random(n) < shared
    luck = np.where(alike[None, :, None, None], common, rng.random((7, n, BUDGET, 3))).reshape(-1, BUDGET, 3)
    condition, number = np.repeat(np.arange(7), n), np.tile(np.arange(n), 7)
    actions, trapped = np.zeros((7 * n, BUDGET), int), np.zeros(7 * n, bool)
    actions[:, 0] = 4 * luck[:, 0, 0]
    for t in range(1, BUDGET):
        actions[:, t] = (actions[:, t - 1] + 1 + (3 * luck[:, t, 0]).astype(int)) % 4
        if t >= 3:
            trapped = np.where(trapped, luck[:, t, 1] < 0.9, luck[:, t, 1] < np.array(trap)[condition])
            actions[trapped, t] = actions[trapped, t - 3]
    onset, step = onset_batch(actions), np.arange(1, BUDGET + 1)
    pace = 1 - (1 - np.array(success)[condition, None]) ** (1 / (BUDGET - 3))
    opens = (luck[:, :, 2] < pace) & (step >= 4)
    length = np.where(opens.any(axis=1), opens.argmax(axis=1) + 1, BUDGET)
    return Outcomes(
        dose=P[condition],
        repetition=1 + number // 10,
        trial=1 + number % 10,
        length=length,
        solved=opens.any(axis=1),
        onset=np.where(onset <= length, onset, 0),
    )


def columns(rows):
    """Outcomes from rows of (p, trial, length, solved, onset)."""
    p, trial, length, solved, onset = zip(*rows, strict=True)
    return Outcomes(
        dose=np.array(p, dtype=float),
        repetition=np.ones(len(rows), dtype=int),
        trial=np.array(trial),
        length=np.array(length),
        solved=np.array(solved, dtype=bool),
        onset=np.array(onset),
    )


def rejections(test, studies, seed, **settings):
    """In how many of these studies a test says p < .05."""
    rng = np.random.default_rng(seed)
    found = [test(world(rng, **settings)) for _ in range(studies)]
    return sum(p is not None and p < 0.05 for p in found)


def primary(outcomes):
    return loop_onset_logrank(outcomes).primary.p_value


# ---- the excess of events


def test_the_excess_is_the_log_ranks():
    for seed in range(5):
        found = world(np.random.default_rng(seed), trap=TRAP)
        group, until = found.dose > 0, np.where(found.looped, found.onset, found.length)
        running, event = grid(until, found.looped)
        total = excess(group[None].astype(float), event, running, cluster=found.luck).total
        expected = 0.0
        for t in range(1, BUDGET + 1):
            ahead = until >= t
            if ahead.any():
                expected += np.sum(found.onset == t) * np.mean(group[ahead])
        assert total == pytest.approx([np.sum(found.looped & group) - expected])


def test_its_variance_is_that_of_independent_trials_where_trials_are_independent():
    rng, ratios = np.random.default_rng(8), []
    for _ in range(60):
        found = world(rng, FLAT, n=100)
        until = np.where(found.looped, found.onset, found.length)
        running, event = grid(until, found.looped)
        here = excess((found.dose > 0)[None].astype(float), event, running, cluster=found.luck)
        statistic, _ = survdiff(until, found.looped.astype(int), found.dose > 0)
        independent = here.total[0] ** 2 / statistic
        ratios.append(here.covariance[0, 0] / independent)
    assert np.mean(ratios) == pytest.approx(1.0, abs=4 * np.std(ratios) / np.sqrt(60))


# ---- does noise put loops off?


def test_noise_that_frees_from_loops_is_found_with_its_direction():
    found = loop_onset_logrank(world(np.random.default_rng(1), trap=TRAP))
    assert found.primary.p_value < 0.005
    assert found.primary.hazard_ratio < 0.7
    assert found.p_all < 0.01
    assert found.primary.lowest.events > found.primary.lowest.expected
    assert found.primary.lowest.by_step() > found.primary.higher.by_step()
    lowest, higher = found.primary.lowest, found.primary.higher
    assert (lowest.doses, higher.doses, lowest.n, higher.n) == ((0.0,), tuple(P[1:].tolist()), 30, 180)
    assert lowest.expected + higher.expected == pytest.approx(lowest.events + higher.events)


def test_onset_is_censored_where_the_trial_ends():
    short = columns([(0.0, i, 6, 1, 0) for i in range(1, 9)] + [(0.4, i, 20, 0, 8) for i in range(1, 9)])
    found = loop_onset_logrank(short).primary
    assert (found.lowest.by_step(), found.higher.by_step()) == (0.0, 1.0)
    assert (found.lowest.expected, found.higher.expected) == (0.0, 8.0)
    assert (found.p_value, found.hazard_ratio) == (1.0, None)  # nobody at p = 0 ran on to step 8


def test_each_comparison_is_its_own_and_corrected_as_by_holm():
    found = loop_onset_logrank(world(np.random.default_rng(3), trap=TRAP))
    assert [c.higher.doses for c in found.each] == [(p,) for p in P[1:].tolist()]
    raw = [c.p_value for c in found.each]
    assert [c.p_adjusted for c in found.each] == pytest.approx(multipletests(raw, method="holm")[1].tolist())
    alone = world(np.random.default_rng(3), trap=TRAP)
    pair = loop_onset_logrank(alone.at((alone.dose == 0) | (alone.dose == 0.4)))
    assert pair.primary.p_value == found.each[3].p_value
    assert pair.p_all < 1e-5


def test_an_agent_that_plays_alike_at_every_p_shows_no_difference_and_no_more_than_once():
    one = world(np.random.default_rng(4), FLAT, shared=1.0)
    onset = loop_onset_logrank(one)
    assert (onset.primary.p_value, onset.p_all, onset.primary.hazard_ratio) == (1.0, 1.0, pytest.approx(1.0))


def test_with_little_to_go_on_nothing_is_claimed():
    one_p = loop_onset_logrank(columns([(0.2, 1, 20, 0, 9), (0.2, 2, 20, 0, 0)]))
    assert (one_p.primary, one_p.each, one_p.p_all) == (None, (), None)
    one_trial = loop_onset_logrank(columns([(0.0, 1, 20, 0, 9), (0.2, 1, 20, 0, 12)]))
    assert one_trial.primary.p_value is None
    nothing = loop_onset_logrank(columns([(p, i, 20, 0, 0) for p in (0, 0.4) for i in range(8)]))
    assert (nothing.primary.p_value, nothing.p_all, nothing.primary.direction) == (1.0, 1.0, 0)
    three = world(np.random.default_rng(1)).at(np.tile(np.arange(30) < 3, 7))
    assert loop_onset_logrank(three).p_all is None
    empty = columns([(0.0, 1, 20, 0, 9)]).at(np.array([False]))
    assert loop_onset_logrank(empty).primary is None


@pytest.mark.parametrize("clusters", range(2, 20))
def test_a_test_that_could_never_reject_is_none(clusters):
    """However clear: all loop at once under noise, none ever without. The statistic never exceeds the clusters."""
    clear = columns(
        [row for i in range(clusters) for row in ((0.0, i, 20, 0, 0), *((p, i, 6, 0, 6) for p in P[1:].tolist()))]
    )
    found = loop_onset_logrank(clear)
    assert (found.primary.p_value is None) == (clusters <= 6)
    assert found.primary.p_value is None or found.primary.p_value < 0.05
    assert found.primary.direction == 1
    assert (found.p_all is None) == (clusters < 4)  # here only one direction varies between clusters


def test_trials_played_twice_under_the_same_luck_are_no_more_evidence():
    once = world(np.random.default_rng(8), trap=TRAP)
    twice = Outcomes(**{name: np.repeat(getattr(once, name), 2) for name in Outcomes.__slots__})
    one, two = loop_onset_logrank(once).primary, loop_onset_logrank(twice).primary
    assert two.hazard_ratio == pytest.approx(one.hazard_ratio)
    assert two.p_value == pytest.approx(one.p_value, rel=0.25)


# ---- size and power


@pytest.mark.parametrize("shared", [0.0, 0.5, 1.0])
def test_nothing_is_found_where_nothing_is(shared):
    """Loops and success have nothing to do with each other, and success differs over p."""
    assert rejections(primary, 120, 21, shared=shared) <= stats.binom.ppf(0.999, 120, 0.06)


def test_what_there_is_is_found():
    assert rejections(primary, 60, 1, trap=TRAP) >= 54
