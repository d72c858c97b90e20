"""Action loops against their definition: brute force on every short trial, laws on longer ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_definition import copies, from_the_left, patterns, truth

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops import (
    LONGEST_ILP,
    LONGEST_SEARCH,
    LoopCover,
    Rule,
    Solver,
    any_loop,
    any_loop_batch,
    cover,
    parse_sequence,
)

RULES: tuple[Rule, ...] = ("free", "repeat", "whole")
SOLVERS: tuple[Solver, ...] = ("dp", "ilp")

TRIALS = st.integers(2, 4).flatmap(lambda k: st.lists(st.integers(0, k - 1), max_size=20)).map(tuple)
CYCLES = st.tuples(st.lists(st.integers(0, 3), min_size=1, max_size=6), st.integers(2, 6)).map(
    lambda cycle: tuple(cycle[0] * cycle[1])[:20]
)


def assert_lawful(trial: Sequence[int], found: LoopCover, rule: Rule, overlap: bool, min_length: int) -> None:
    """What holds of every cover: disjoint pieces, each a copy of a loop, chosen as the rule asks."""
    words = copies(trial, min_length, overlap)
    assert found.n == len(trial)
    assert found.any_loop == bool(words)
    assert found.covered == sum(length for _, length in found.intervals)
    ends = [0] + [start + length for start, length in found.intervals]
    assert all(start >= end for (start, _), end in zip(found.intervals, ends, strict=False))
    assert ends[-1] <= found.n
    chosen: dict[tuple[int, ...], list[int]] = {}
    for start, length in found.intervals:
        chosen.setdefault(tuple(trial[start : start + length]), []).append(start)
    assert tuple(chosen) == found.words
    assert chosen.keys() <= words.keys()
    if rule != "free":
        assert all(len(at) >= 2 for at in chosen.values())
    if rule == "whole":
        for word, at in chosen.items():
            assert at == from_the_left(words[word], len(word))


@pytest.mark.parametrize(("actions", "longest"), [(2, 9), (3, 7), (4, 7)])
@pytest.mark.parametrize("overlap", [False, True])
def test_whether_a_short_trial_loops_is_the_definition(actions: int, longest: int, overlap: bool) -> None:
    for trial in patterns(actions, longest):
        for min_length in (1, 2, 3, 4):
            expected = bool(copies(trial, min_length, overlap))
            assert any_loop(trial, min_length=min_length, overlap=overlap) == expected, trial


@pytest.mark.parametrize(("actions", "longest"), [(2, 7), (3, 7)])
def test_the_linear_programme_is_optimal_under_each_rule(actions: int, longest: int) -> None:
    for trial in patterns(actions, longest):
        if not any_loop(trial):
            continue
        expected = truth(trial, overlap=False)
        for rule in RULES:
            found = cover(trial, rule=rule, solver="ilp")
            assert found.covered == getattr(expected, rule), (trial, rule)
            assert_lawful(trial, found, rule, overlap=False, min_length=3)


def test_the_linear_programme_is_optimal_where_copies_may_overlap() -> None:
    for trial in patterns(2, 7):
        expected = truth(trial, overlap=True)
        for rule in RULES:
            found = cover(trial, rule=rule, solver="ilp", overlap=True)
            assert found.covered == getattr(expected, rule), (trial, rule)


@settings(deadline=None, max_examples=60)
@given(trial=TRIALS | CYCLES, overlap=st.booleans(), min_length=st.integers(1, 5), rule=st.sampled_from(RULES))
def test_both_solvers_cover_equally_much(trial: tuple[int, ...], overlap: bool, min_length: int, rule: Rule) -> None:
    exact, literal = (
        cover(trial, overlap=overlap, min_length=min_length, solver=solver, rule=rule) for solver in SOLVERS
    )
    assert exact.covered == literal.covered
    assert exact.any_loop == literal.any_loop
    assert_lawful(trial, exact, rule, overlap, min_length)
    assert_lawful(trial, literal, rule, overlap, min_length)


@pytest.mark.parametrize("kind", ["random", "loopy"])
@pytest.mark.parametrize(("n", "trials"), [(20, 12), (40, 4), (60, 2), (90, 1)])
@pytest.mark.parametrize("rule", RULES)
def test_both_solvers_cover_equally_much_of_longer_trials(kind: str, n: int, trials: int, rule: Rule) -> None:
    rng = np.random.default_rng(n)
    for _ in range(trials):
        trial = rng.integers(0, 4, n).tolist() if kind == "random" else loopy(rng, n)
        exact, literal = (cover(trial, rule=rule, solver=solver) for solver in SOLVERS)
        assert exact.covered == literal.covered
        assert_lawful(trial, exact, rule, False, 3)


def loopy(rng: np.random.Generator, n: int) -> list[int]:
    """Cycles of two to six actions, each a few times, and one action in ten another."""
    trial: list[int] = []
    while len(trial) < n:
        trial += rng.integers(0, 4, rng.integers(2, 7)).tolist() * int(rng.integers(1, 5))
    return [int(rng.integers(0, 4)) if rng.random() < 0.1 else action for action in trial[:n]]


@settings(deadline=None, max_examples=150)
@given(trial=st.lists(st.integers(0, 3), max_size=11).map(tuple))
def test_both_solvers_choose_equally_few_pieces(trial: tuple[int, ...]) -> None:
    exact, literal = (cover(trial, solver=solver) for solver in SOLVERS)
    assert len(exact.intervals) == len(literal.intervals)


@settings(deadline=None, max_examples=100)
@given(trial=TRIALS | CYCLES, overlap=st.booleans())
def test_a_stricter_rule_covers_no_more(trial: tuple[int, ...], overlap: bool) -> None:
    free, repeat, whole = (cover(trial, rule=rule, overlap=overlap) for rule in RULES)
    assert whole.covered <= repeat.covered <= free.covered <= free.n
    assert_lawful(trial, repeat, "repeat", overlap, 3)
    assert_lawful(trial, whole, "whole", overlap, 3)


@settings(deadline=None)
@given(trial=TRIALS | CYCLES, overlap=st.booleans(), names=st.permutations(range(4)))
def test_the_names_of_the_actions_and_the_direction_of_time_do_not_matter(
    trial: tuple[int, ...], overlap: bool, names: list[int]
) -> None:
    found = cover(trial, overlap=overlap)
    renamed = cover([f"joint {names[action]}" for action in trial], overlap=overlap)
    assert renamed.intervals == found.intervals
    assert renamed.any_loop == found.any_loop
    assert cover(trial[::-1], overlap=overlap).covered == found.covered


@given(trial=TRIALS | CYCLES, overlap=st.booleans(), min_length=st.integers(1, 5))
def test_a_trial_is_covered_if_and_only_if_it_loops(trial: tuple[int, ...], overlap: bool, min_length: int) -> None:
    found = cover(trial, overlap=overlap, min_length=min_length)
    looping = any_loop(trial, overlap=overlap, min_length=min_length)
    assert looping == found.any_loop == (found.covered > 0) == (found.share > 0)


@given(
    trials=st.integers(0, 20).flatmap(
        lambda n: st.lists(st.lists(st.integers(0, 2), min_size=n, max_size=n), min_size=1, max_size=9)
    ),
    overlap=st.booleans(),
    min_length=st.integers(1, 5),
)
def test_a_batch_is_its_trials(trials: list[list[int]], overlap: bool, min_length: int) -> None:
    found = any_loop_batch(np.array(trials, dtype=np.int8), overlap=overlap, min_length=min_length)
    assert found.tolist() == [any_loop(t, overlap=overlap, min_length=min_length) for t in trials]


@pytest.mark.parametrize(
    ("trial", "free", "repeat", "whole"),
    [
        ("001001010", 9, 6, 6),
        ("000010010000", 12, 12, 8),
        ("010101010", 9, 8, 8),
        ("ABCABCABC", 9, 9, 9),
        ("AAAA", 0, 0, 0),
        ("ABCDABDC", 0, 0, 0),
    ],
)
def test_worked_examples(trial: str, free: int, repeat: int, whole: int) -> None:
    for solver in SOLVERS:
        assert [cover(trial, rule=rule, solver=solver).covered for rule in RULES] == [free, repeat, whole]


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_cycle_is_reported_as_one_loop(solver: Solver) -> None:
    found = cover(parse_sequence("A B C A B C A B C"), solver=solver)
    assert found.words == (("A", "B", "C"),)
    assert found.intervals == ((0, 3), (3, 3), (6, 3))
    assert (found.n, found.any_loop, found.covered, found.share) == (9, True, 9, 1.0)


@pytest.mark.parametrize("period", [3, 4, 5, 7])
@pytest.mark.parametrize("times", [2, 3, 4, 5, 6, 9])
def test_any_cycle_is_reported_as_its_period(period: int, times: int) -> None:
    found = cover(list(range(period)) * times)
    assert found.words == (tuple(range(period)),)
    assert found.intervals == tuple((at * period, period) for at in range(times))


@pytest.mark.parametrize("times", [3, 4, 5])
def test_the_linear_programme_reports_the_period_too(times: int) -> None:
    assert cover("ABC" * times, solver="ilp") == cover("ABC" * times)


def test_of_the_fewest_pieces_the_first_are_longest() -> None:
    assert cover("ABCABCABCAB").intervals == ((0, 5), (5, 3), (8, 3))


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(("trial", "pieces"), [("AABBBAABABBBABBB", 4), ("BBBABBBBABBAAB", 3), ("AABABBABABBBBB", 2)])
def test_fewest_pieces_are_chosen_where_more_would_cover_as_much(trial: str, pieces: int, solver: Solver) -> None:
    assert len(cover(trial, solver=solver).intervals) == pieces


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("rule", RULES)
def test_a_cycle_is_one_loop_under_every_rule(rule: Rule, solver: Solver) -> None:
    assert cover("ABC" * 6, rule=rule, solver=solver).words == (("A", "B", "C"),)
    assert cover("ABCDEFG" * 2, rule=rule, solver=solver).words == (tuple("ABCDEFG"),)


def test_loops_that_always_follow_each_other_are_one_loop() -> None:
    assert cover("001001010").covered > cover("001001010", rule="repeat").covered  # so it is searched for
    found = cover("001001010XABCDEFGYABCDEFG", rule="repeat")
    assert (found.covered, found.words[-1]) == (20, tuple("ABCDEFG"))


def test_two_copies_that_share_actions_count_only_on_request() -> None:
    assert not any_loop("AAAA")
    assert any_loop("AAAA", overlap=True)
    assert cover("AAAA", overlap=True).intervals == ((0, 3),)
    assert cover("AAAA", overlap=True, rule="whole", solver="ilp").covered == 0


def test_a_trial_of_thousands_of_steps_is_covered_exactly() -> None:
    rng = np.random.default_rng(5)
    half = rng.integers(0, 1000, 1500).tolist()
    found = cover(half + half)
    assert found.intervals == ((0, 1500), (1500, 1500))


def test_an_empty_trial_has_no_share() -> None:
    assert cover(()) == LoopCover(n=0, any_loop=False, covered=0, words=(), intervals=())
    assert cover(()).share == 0.0
    assert any_loop_batch(np.zeros((2, 0), dtype=int)).tolist() == [False, False]


@pytest.mark.parametrize("rule", ["repeat", "whole"])
def test_trials_too_long_for_a_search_are_refused_with_a_way_out(rule: Rule) -> None:
    assert cover("ABC" * (LONGEST_SEARCH // 3), rule=rule).share == 1.0
    with pytest.raises(
        BadValue, match=f"got {LONGEST_SEARCH + 1}, expected at most {LONGEST_SEARCH}; try the solver ilp"
    ):
        cover("A" * (LONGEST_SEARCH + 1), rule=rule)
    with pytest.raises(BadValue, match=f"got {LONGEST_ILP + 1}, expected at most {LONGEST_ILP}; dp with the rule free"):
        cover("A" * (LONGEST_ILP + 1), rule=rule, solver="ilp")


def test_redundant_actions_are_those_after_the_first_copy() -> None:
    assert cover("ABCABCABC").redundant == 6
    assert cover("ABCDXABCD").redundant == 4
    assert cover("001001010").redundant == 3  # 001 001, and one 010
    assert cover("ABCDABDC").redundant == 0


def test_bad_settings_are_refused() -> None:
    with pytest.raises(BadValue, match="free, repeat or whole"):
        cover("ABC", rule="loose")  # type: ignore[arg-type]
    with pytest.raises(BadValue, match="dp or ilp"):
        cover("ABC", solver="cp")  # type: ignore[arg-type]
    for refuse in (cover, any_loop):
        with pytest.raises(BadValue, match="at least 1"):
            refuse("ABC", min_length=0)
    with pytest.raises(BadValue, match="trials, n"):
        any_loop_batch(np.zeros(4, dtype=int))
    with pytest.raises(FrozenInstanceError):
        cover("ABC").n = 4  # type: ignore[misc]
