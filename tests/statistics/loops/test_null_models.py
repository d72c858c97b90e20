"""Nulls that trials set themselves: against enumeration, against exact levels, and in cases known beforehand."""

from __future__ import annotations

from itertools import pairwise, permutations, product
from math import prod

import numpy as np
import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops import any_loop, null_models
from lockprobe.statistics.loops.chance import chance_level
from lockprobe.statistics.loops.null_models import TrialNull, expected_loop_rate, markov_chain

EVERY: tuple[TrialNull, ...] = ("uniform", "no-repeat", "markov", "permutation")


def random_trials(trials: int, shortest: int, longest: int, actions: int = 4) -> list[list[int]]:
    rng = np.random.default_rng(7)
    return [rng.integers(0, actions, rng.integers(shortest, longest + 1)).tolist() for _ in range(trials)]


@pytest.mark.parametrize("overlap", [False, True])
@pytest.mark.parametrize("trial", ["ABCABC", "AABBCC", "ABABAB", "ABABABC", "AAAAAAB", "ABCDABC", "ABCABCD", "AAAA"])
def test_shuffles_of_a_short_trial_counted_by_hand(trial: str, overlap: bool) -> None:
    orders = list(permutations(trial))
    for min_length in (2, 3):
        by_hand = sum(any_loop(order, overlap=overlap, min_length=min_length) for order in orders) / len(orders)
        level = expected_loop_rate([trial], "permutation", actions=4, overlap=overlap, min_length=min_length)
        assert level.probability == pytest.approx(by_hand, abs=1e-12)
        assert (level.method, level.error) == ("exact", 0.0)


@pytest.mark.parametrize("shape", [(4, 3, 2, 1), (3, 3, 3), (5, 3, 1), (9, 1)])
def test_drawn_shuffles_agree_with_all_orders(shape: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(null_models, "SHUFFLES", 20_000)
    trial = np.repeat(np.arange(len(shape)), shape).tolist()
    by_hand = null_models._every_order(shape, 3, overlap=False).probability
    monkeypatch.setattr(null_models, "ENUMERABLE", 0)
    drawn = expected_loop_rate([trial], "permutation", actions=4)
    assert drawn.method == "simulation"
    assert abs(drawn.probability - by_hand) < 4 * drawn.error


def test_a_shuffle_keeps_what_the_trial_did() -> None:
    shapes = [(3, 2, 1), (9, 4, 4, 3), (7, 7)]
    walks = null_models._shuffled(shapes, 3, seed=1)
    assert walks.shape == (3, null_models.SHUFFLES, 20)
    for shape, rows in zip(shapes, walks, strict=True):
        for row in rows:
            assert np.bincount(row)[: len(shape)].tolist() == list(shape)
            assert sorted(set(row[: sum(shape)].tolist())) == list(range(len(shape)))
            assert len(set(row[sum(shape) :].tolist())) == 20 - sum(shape)


def test_shuffling_what_is_random_changes_nothing() -> None:
    trials = random_trials(400, 12, 12)
    level = expected_loop_rate(trials, "permutation", actions=4)
    assert level.probability == pytest.approx(chance_level(12).probability, abs=0.02)


def test_a_chain_fitted_to_random_trials_is_the_random_agent() -> None:
    level = expected_loop_rate(random_trials(1, 40_000, 40_000), "markov", actions=4)
    assert level.probability == 1.0
    first, after = markov_chain(random_trials(1, 40_000, 40_000))
    assert first.sum() == 1
    assert np.allclose(after, 0.25, atol=0.02)
    trials = random_trials(2_000, 20, 20)
    level = expected_loop_rate(trials, "markov", actions=4)
    assert abs(level.probability - chance_level(20).probability) < 4 * level.error


def test_a_chain_fitted_to_trials_without_repeats_has_none() -> None:
    rng = np.random.default_rng(3)
    trials = [(rng.integers(1, 4, 15).cumsum() % 4).tolist() for _ in range(2_000)]
    level = expected_loop_rate(trials, "markov", actions=4)
    assert abs(level.probability - chance_level(15, null="no-repeat").probability) < 4 * level.error
    assert markov_chain(trials)[1].diagonal().tolist() == [0.0] * 4


def test_a_fitted_chain_counted_by_hand() -> None:
    trials = ["ABABCA", "BACCABB", "CCA", "AACBAC"]
    first, after = markov_chain(trials)
    order = {"A": 0, "B": 1, "C": 2}
    counts = {pair: sum(list(pairwise(trial)).count(pair) for trial in trials) for pair in product("ABC", repeat=2)}
    for (a, b), count in counts.items():
        row = sum(counts[a, other] for other in "ABC")
        assert after[order[a], order[b]] == pytest.approx(count / row)
    assert first.tolist() == [0.5, 0.25, 0.25]
    by_hand = []
    for trial in trials:
        walks = product(range(3), repeat=len(trial))
        by_hand.append(
            sum(first[walk[0]] * prod(after[a, b] for a, b in pairwise(walk)) for walk in walks if any_loop(walk))
        )
    level = expected_loop_rate(trials, "markov", actions=3)
    assert abs(level.probability - np.mean(by_hand)) < 4 * level.error
    assert level.probability > 0


def test_an_action_that_only_ends_trials_is_followed_by_any_in_their_shares() -> None:
    first, after = markov_chain(["ABAC", "AB", ""])
    assert first.tolist() == [1.0, 0.0, 0.0]
    assert after[0].tolist() == [0.0, 2 / 3, 1 / 3]
    assert after[1].tolist() == [1.0, 0.0, 0.0]
    assert after[2].tolist() == [3 / 6, 2 / 6, 1 / 6]


def test_going_round_is_a_habit_of_one_step() -> None:
    trials = ["ABCABCABC", "BCABCABCA"]
    assert expected_loop_rate(trials, "markov", actions=4).probability == 1.0
    assert expected_loop_rate(trials, "permutation", actions=4).probability < 0.5


@pytest.mark.parametrize("null", EVERY)
def test_levels_are_those_of_each_trials_own_length(null: TrialNull) -> None:
    short, long = random_trials(30, 3, 5), random_trials(30, 20, 20)
    none = expected_loop_rate(short, null, actions=4)
    assert (none.probability, none.method, none.error) == (0.0, "exact", 0.0)
    some = expected_loop_rate(long, null, actions=4)
    mixed = expected_loop_rate([*short, *long], null, actions=4)
    assert some.probability > 0.7
    assert mixed.probability == pytest.approx(some.probability / 2, abs=0.03)
    assert expected_loop_rate(["", *short], null, actions=4).probability == 0.0


@pytest.mark.parametrize("null", EVERY)
def test_the_names_of_actions_do_not_matter_and_a_seed_repeats(null: TrialNull) -> None:
    trials = random_trials(30, 8, 20)
    level = expected_loop_rate(trials, null, actions=4)
    assert level == expected_loop_rate([["wxyz"[a] for a in trial] for trial in trials], null, actions=4)
    other = expected_loop_rate(trials, null, actions=4, seed=1)
    assert abs(level.probability - other.probability) <= 4 * (level.error + other.error)
    assert (level == other) == (level.method == "exact")


def test_uniform_levels_are_the_mean_over_lengths() -> None:
    level = expected_loop_rate(["ABCD" * 5, "ABCD" * 2, "ABCD" * 5, ""], "uniform", actions=4)
    by_hand = (2 * chance_level(20).probability + chance_level(8).probability) / 4
    assert level.probability == pytest.approx(by_hand, abs=1e-12)
    assert (level.method, level.error) == ("exact", 0.0)
    level = expected_loop_rate([range(6), range(19), [*range(6)] * 4], "no-repeat", actions=19)
    parts = [chance_level(length, 19, null="no-repeat") for length in (6, 19, 24)]
    assert level.probability == pytest.approx(np.mean([part.probability for part in parts]))
    assert level.error == pytest.approx(sum(part.error for part in parts) / 3)


@pytest.mark.parametrize("null", EVERY)
def test_long_trials_are_answered_from_their_beginning(null: TrialNull) -> None:
    trials = [list(range(4)) * 2_500, [0] * 10_000, *random_trials(3, 5_000, 5_000)]
    assert expected_loop_rate(trials, null, actions=4).probability == pytest.approx(1.0, abs=1e-9)


def test_bad_settings_are_refused() -> None:
    with pytest.raises(BadValue, match="null"):
        expected_loop_rate(["AB"], "other", actions=4)  # type: ignore[arg-type]
    with pytest.raises(BadValue, match="trials"):
        expected_loop_rate([], "uniform", actions=4)
    with pytest.raises(BadValue, match="at least the 3"):
        expected_loop_rate(["ABC"], "uniform", actions=2)
    with pytest.raises(BadValue, match="at least 1"):
        expected_loop_rate(["ABCABC"], "markov", actions=4, min_length=0)


@pytest.mark.parametrize("null", ["markov", "permutation"])
def test_more_actions_than_can_be_fitted_are_refused(null: TrialNull, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(BadValue, match=f"distinct actions for the null {null}: got 100000, expected at most 2000"):
        expected_loop_rate([range(100_000)], null, actions=4)
    monkeypatch.setattr(null_models, "MOST_ACTIONS", 4)
    assert expected_loop_rate(["ABCDABCD"], null, actions=4).probability > 0
    with pytest.raises(BadValue, match="got 5, expected at most 4"):
        expected_loop_rate(["ABCD", "EA"], null, actions=4)
