"""Fractional factorial designs: orthogonal columns, resolution IV, and their recognition by specs."""

from itertools import combinations
from math import prod

import pytest

from lockprobe.statistics.factorial.design import factorials_of, fraction
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.study_design import design_of

FULL = ["tremble?p=0.2", "flip?p=0.4", "nudge"]
EIGHT = [" + ".join(one) for size in (1, 2, 3) for one in combinations(FULL, size)]


@pytest.mark.parametrize("factors", [4, 5, 6, 7, 8])
def test_no_effect_of_a_factor_is_mixed_with_another_or_an_interaction_of_two(factors):
    columns = list(zip(*fraction(factors), strict=True))
    assert len(columns) == factors
    pairs = [tuple(map(prod, zip(*two, strict=True))) for two in combinations(columns, 2)]
    for column in columns:
        assert sum(column) == 0
        assert all(sum(map(prod, zip(column, pair, strict=True))) == 0 for pair in pairs)
    assert len({*fraction(factors)}) == 16


def found_in(conditions):
    return factorials_of(design_of(study("flips", agent="random", condition=conditions)).arms, "symbolic?tell=state")


def test_a_full_design_of_three_is_one():
    (found,) = found_in(EIGHT)
    assert sorted(found.factors) == ["flip.p", "nudge", "tremble.p"]
    assert found.levels["flip.p"] == ("", "0.4")
    assert found.runs["truth"] == (-1, -1, -1)
    assert sum(levels[found.factors.index("nudge")] for levels in found.runs.values()) == 0


def test_what_is_unbalanced_or_has_two_factors_is_none():
    assert found_in(EIGHT[:-1]) == []
    assert found_in(["tremble?p=0.2", "flip?p=0.4", "tremble?p=0.2 + flip?p=0.4"]) == []
    assert found_in([one.replace("flip?p=0.4 + nudge", "flip?p=0.2 + nudge") for one in EIGHT]) == []
