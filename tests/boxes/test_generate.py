"""A thousand boxes, each one valid or refused for a reason that holds."""

from collections import Counter
from dataclasses import replace

import pytest

from lockprobe.boxes.box import MAX_JOINTS, Lockbox
from lockprobe.boxes.generate import Recipe, generate
from lockprobe.boxes.solve import optimum
from lockprobe.boxes.structures import STRUCTURES
from lockprobe.foundation.errors import BadValue, UnknownName

LAYOUTS = ("serial", "zigzag", "ngram", "grid", "scattered", "misleading")
RANDOM = tuple(f"random-{joints}" for joints in range(2, 9))
FAMILIES = (*STRUCTURES, *RANDOM * 4)


def spread(i):
    """Recipe number i of a set that goes through everything."""
    return Recipe(
        family=FAMILIES[i % len(FAMILIES)],
        layout=LAYOUTS[i // 7 % 6],
        dealt=i % 2 == 0,
        alternatives=1 + i // 5 % 4,
        literals=1 + i // 11 % 4,
        negative=i // 13 % 5 / 5,
        shortest=1 + i // 17 % 3,
        seed=i,
    )


def test_a_thousand_boxes_are_valid_or_refused_with_the_reason(brute_optimum):
    """The optimum of each is that of a solver that shares nothing with the library's."""
    counts = Counter()
    for i in range(0, 3_000, 3):
        recipe = spread(i)
        found = generate(recipe)
        if isinstance(found, Lockbox):
            counts["made"] += 1
            assert 2 <= len(found.joints) <= MAX_JOINTS
            steps = optimum(found)
            assert steps >= recipe.shortest
            assert steps == brute_optimum(found)
        else:
            kind = found.partition(":")[0]
            counts[kind] += 1
            easier = generate(replace(recipe, shortest=1))
            assert isinstance(easier, Lockbox) == (kind == "too short")
            if isinstance(easier, Lockbox):
                assert brute_optimum(easier) < recipe.shortest
    assert set(counts) == {"made", "too short", "unsolvable", "contradictory"}
    assert counts["made"] > 500


@pytest.mark.parametrize(
    ("change", "mistake", "message"),
    [
        ({"family": "chian"}, UnknownName, "no family is called 'chian'.*random-2 to random-8"),
        ({"family": "random-9"}, UnknownName, "no family is called 'random-9'"),
        ({"family": "random-5-17"}, UnknownName, "no family is called 'random-5-17'"),
        ({"layout": "round"}, UnknownName, "no layout is called 'round'; there are: serial, zigzag, ngram, grid"),
        ({"alternatives": 0}, BadValue, "alternatives: got 0, expected a whole number from 1 to 4"),
        ({"literals": 8}, BadValue, "literals: got 8, expected a whole number from 1 to 7"),
        ({"negative": 1.1}, BadValue, "negative: got 1.1, expected a number from 0 to 1"),
        ({"negative": float("nan")}, BadValue, "negative"),
        ({"shortest": 0}, BadValue, "shortest: got 0"),
        ({"seed": -1}, BadValue, "seed: got -1"),
        ({"seed": 2**31}, BadValue, "seed: got 2147483648"),
    ],
)
def test_recipes_out_of_range_are_refused(change, mistake, message):
    with pytest.raises(mistake, match=message):
        Recipe(**change)
