"""Clauses that fit observed moves: right everywhere, and as few as there can be."""

from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest

from lockprobe.boxes.box import bits
from lockprobe.boxes.families import box
from lockprobe.boxes.observed_moves import Push, corrected, fitting_clauses
from lockprobe.boxes.state_space import space_of


def reachable(puzzle):
    return [tuple(bool(number >> j & 1) for j in range(len(puzzle.joints))) for number in space_of(puzzle).reachable]


def pushes(rules, truth, configurations):
    return [
        Push(configuration=now, joint=j, allowed=rules.may_move(now, j), moved=truth.may_move(now, j))
        for now in configurations
        for j in range(len(rules.joints))
    ]


def _inverted(clauses):
    return tuple({other: not position for other, position in clause.items()} for clause in clauses)


@pytest.mark.parametrize("seed", range(12))
def test_the_corrected_rules_say_what_was_seen_everywhere(seed):
    truth = box(f"random-5-{seed}")
    rules = replace(truth, interlock={name: _inverted(clauses) for name, clauses in truth.interlock.items()})
    seen = reachable(truth)
    found, left = corrected(rules, pushes(rules, truth, seen))
    for now in seen:
        for j, name in enumerate(truth.names):
            assert name in left or found.may_move(now, j) == truth.may_move(now, j), (bits(now), name)
    for name, why in left.items():
        assert why == "never moved"
        assert not any(truth.may_move(now, truth.names.index(name)) for now in seen)


def test_rules_that_agree_stay_as_they_are():
    for name in ("chain-4", "bichain-4", "gray-code", "random-6-3"):
        puzzle = box(name)
        assert corrected(puzzle, pushes(puzzle, puzzle, reachable(puzzle))) == (puzzle, {})


def fewest(seen, joint):
    """The fewest clauses by trying all sets of them."""
    others = [i for i in range(len(next(iter(seen)))) if i != joint]
    cubes = [
        [now for now in seen if all(p is None or now[i] == p for i, p in zip(others, cube, strict=True))]
        for cube in product((None, 0, 1), repeat=len(others))
    ]
    right = [set(cube) for cube in cubes if cube and all(seen[now] for now in cube)]
    wanted = {now for now, moved in seen.items() if moved}
    return next(n for n in range(1, 9) if any(set().union(*some) == wanted for some in combinations(right, n)))


@pytest.mark.parametrize("seed", range(8))
def test_no_smaller_set_of_clauses_fits(seed):
    puzzle, rng = replace(box("chain-4"), interlock={}), np.random.default_rng(seed)
    seen = {now: bool(rng.random() < 0.4) for now in product((False, True), repeat=4) if not now[0]}
    if any(seen.values()):
        assert len(fitting_clauses(puzzle, 0, seen)) == fewest(seen, 0)


def test_a_clause_of_the_box_that_fits_is_kept_word_for_word():
    puzzle = box("chain-4")
    wide = {"slider-1": True, "slider-2": True}
    rules = replace(puzzle, interlock={**puzzle.interlock, puzzle.target: (wide, {"revolute-right": True})})
    seen = {now: now[1] and now[2] for now in product((False, True), repeat=4) if not now[0]}
    assert fitting_clauses(rules, 0, seen) == (wide,)
    assert fitting_clauses(rules, 0, dict.fromkeys(seen, True)) == ({},)
    assert fitting_clauses(rules, 0, dict.fromkeys(seen, False)) == ()


def test_what_no_rule_can_say_counts_for_nothing():
    puzzle = box("chain-3")
    strange = [Push(configuration=puzzle.initial, joint=0, allowed=False, moved=None, disagreement="it broke")]
    assert corrected(puzzle, strange) == (puzzle, {})


def test_a_joint_that_moves_one_way_and_not_back_fits_no_clause():
    puzzle = box("chain-3")
    ratchet = [
        Push(configuration=now, joint=0, allowed=puzzle.may_move(now, 0), moved=not now[0])
        for now in product((False, True), repeat=3)
    ]
    assert corrected(puzzle, ratchet) == (puzzle, {puzzle.names[0]: "moved one way and not back"})
