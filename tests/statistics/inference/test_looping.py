"""Whether noise puts loops off: against brute force and the library, of the right size when luck is shared, and strong."""

import numpy as np
import pytest
from scipy import stats
from statsmodels.duration.survfunc import survdiff

from lockprobe.statistics.inference.excess import excess
from lockprobe.statistics.inference.hazard import looping
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
    """Outcomes from rows of (p, trial, length, onset)."""
    p, trial, length, onset = (np.array(column) for column in zip(*rows, strict=True))
    solved = length < BUDGET
    return Outcomes(
        dose=p.astype(float), repetition=np.ones_like(trial), trial=trial, length=length, solved=solved, onset=onset
    )


def test_the_excess_is_the_log_ranks():
    for seed in range(5):
        found = world(np.random.default_rng(seed), trap=TRAP)
        group, until, expected = found.dose > 0, found.until_loop, 0.0
        for t in range(1, BUDGET + 1):
            expected += np.sum(found.onset == t) * np.mean(group[until >= t]) if (until >= t).any() else 0.0
        total = excess(group.astype(float), until, found.looped, found.luck).total
        assert total == pytest.approx(np.sum(found.looped & group) - expected)


def test_its_variance_is_that_of_independent_trials_where_trials_are_independent():
    rng, ratios = np.random.default_rng(8), []
    for _ in range(60):
        found = world(rng, FLAT, n=100)
        here = excess((found.dose > 0).astype(float), found.until_loop, found.looped, found.luck)
        statistic, _ = survdiff(found.until_loop, found.looped.astype(int), found.dose > 0)
        ratios.append(here.error**2 * statistic / here.total**2)
    assert np.mean(ratios) == pytest.approx(1.0, abs=4 * np.std(ratios) / np.sqrt(60))


def test_noise_that_frees_from_loops_is_found_with_its_direction():
    found = looping(world(np.random.default_rng(1), trap=TRAP))
    assert (found.p_value < 0.005, found.ratio < 0.7, found.direction) == (True, True, -1)


def test_onset_is_censored_where_the_trial_ends():
    short = columns([(0.0, i, 6, 0) for i in range(1, 9)] + [(0.4, i, 20, 8) for i in range(1, 9)])
    found = looping(short)  # nobody at p = 0 ran on to step 8
    assert (found.p_value, found.ratio) == (1.0, None)


def test_an_agent_that_plays_alike_at_every_p_shows_no_difference():
    found = looping(world(np.random.default_rng(4), FLAT, shared=1.0))
    assert (found.p_value, found.ratio) == (1.0, pytest.approx(1.0))


def test_with_little_to_go_on_nothing_is_claimed():
    one = columns([(0.2, 1, 20, 9), (0.2, 2, 20, 0)])
    assert looping(one) is looping(one.at(np.zeros(2, dtype=bool))) is None
    assert looping(columns([(0.0, 1, 20, 9), (0.2, 1, 20, 12)])).p_value is None
    nothing = looping(columns([(p, i, 20, 0) for p in (0, 0.4) for i in range(8)]))
    assert (nothing.p_value, nothing.direction) == (1.0, 0)


@pytest.mark.parametrize("clusters", range(2, 20))
def test_a_test_that_could_never_reject_is_none(clusters):
    """However clear: all loop at once under noise, none ever without. The statistic never exceeds the clusters."""
    clear = [row for i in range(clusters) for row in ((0.0, i, 20, 0), *((p, i, 6, 6) for p in P[1:].tolist()))]
    found = looping(columns(clear))
    assert (found.p_value is None) == (clusters <= 6)
    assert found.p_value is None or found.p_value < 0.05
    assert found.direction == 1


def test_trials_played_twice_under_the_same_luck_are_no_more_evidence():
    once = world(np.random.default_rng(8), trap=TRAP)
    two = looping(once.at(np.repeat(np.arange(len(once)), 2)))
    assert two.ratio == pytest.approx(looping(once).ratio)
    assert two.p_value == pytest.approx(looping(once).p_value, rel=0.25)


def rejections(studies, seed, **settings):
    rng = np.random.default_rng(seed)
    p_values = [looping(world(rng, **settings)).p_value for _ in range(studies)]
    return sum(p is not None and p < 0.05 for p in p_values)


@pytest.mark.parametrize("shared", [0.0, 0.5, 1.0])
def test_nothing_is_found_where_nothing_is(shared):
    """Loops and success have nothing to do with each other, and success differs over p."""
    assert rejections(120, 21, shared=shared) <= stats.binom.ppf(0.999, 120, 0.06)


def test_what_there_is_is_found():
    assert rejections(60, 1, trap=TRAP) >= 54
