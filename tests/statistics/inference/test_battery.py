"""All tests of one agent: every question once answered by a test that is recommended, and nothing made up."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.report.prose.hypothesis_tests import QUESTIONS, limits_said
from lockprobe.simulation.audit.simulate import simulate_outcomes
from lockprobe.simulation.audit.simulated_agents import WORLDS, Design
from lockprobe.statistics.inference.battery import infer
from lockprobe.statistics.inference.difference import any_difference
from lockprobe.statistics.inference.hazard import loop_hazard
from lockprobe.statistics.inference.verdict import TestResult
from lockprobe.statistics.outcomes import Outcomes, outcomes


def drawn(name, seed=1, design=None):
    return simulate_outcomes(WORLDS[name], design or WORLDS[name].design, generator(seed, name))


@pytest.mark.parametrize("name", WORLDS)
def test_every_question_has_one_recommended_test(name):
    found = infer(drawn(name), generator(1))
    for question in QUESTIONS:
        asked = [test for test in found.tests if test.question == question]
        assert [test.recommended for test in asked] == [True] + [False] * (len(asked) - 1)
        short = WORLDS[name].slow and question == "harm"  # trials of six steps hold too few loops
        assert short or 0 < asked[0].p_value <= 1
    assert len({test.name for test in found.tests}) == len(found.tests)
    json.dumps(asdict(found), allow_nan=False)


def test_rows_say_what_the_tests_say():
    columns = drawn("loop-trapped")
    found = {test.name: test for test in infer(columns, generator(9)).tests}
    assert (
        found["greatest difference from the lowest dose, permutation"].p_value
        == any_difference(columns, generator(9)).p_value
    )
    hazard = found["success after a loop, Mantel-Haenszel by dose and step"]
    assert (hazard.effect, hazard.low, hazard.high) == (
        (effect := loop_hazard(columns)).odds_ratio,
        effect.low,
        effect.high,
    )
    assert hazard.low < hazard.effect < hazard.high < 1


def test_a_clear_peak_is_found_even_if_one_side_is_all_or_nothing():
    p = np.repeat([0.0, 0.1, 0.2, 0.3, 0.4], 30)
    solved = np.concatenate([np.arange(30) < k for k in (0, 0, 30, 4, 0)])
    n = len(p)
    columns = Outcomes(
        dose=p, repetition=np.ones(n, np.int64), trial=np.tile(np.arange(30) + 1, 5), length=np.full(n, 9),
        solved=solved, onset=np.zeros(n, np.int64),
    )  # fmt: skip
    found = {test.name: test for test in infer(columns, generator(1)).tests}
    assert found["two lines"].p_value < 0.05


def test_a_valley_is_no_peak():
    columns = drawn("inverted-u", design=Design(repetitions=1, trials=100))
    upside_down = Outcomes(**{**{f: getattr(columns, f) for f in columns.__slots__}, "solved": ~columns.solved})
    for name in ("two lines", "Lind-Mehlum"):
        assert {t.name: t for t in infer(columns, generator(1)).tests}[name].rejects
        assert not {t.name: t for t in infer(upside_down, generator(1)).tests}[name].rejects


@pytest.mark.parametrize("trials", ["none", "one p", "one trial"])
def test_too_little_to_test_gives_no_p_value_and_says_why(trials):
    columns = outcomes([]) if trials == "none" else drawn("no-effect")
    if trials == "one p":
        columns = columns.at(columns.dose == 0)
    if trials == "one trial":
        columns = columns.at(np.arange(len(columns)) == 0)
    for test in infer(columns, generator(1)).tests:
        if test.question in ("success", "shape", "looping"):
            assert test.p_value is None, test
        if test.recommended and test.p_value is None:
            assert limits_said(test)


def test_equal_seeds_give_equal_tests():
    columns = drawn("no-effect")
    assert infer(columns, generator(1)).tests == infer(columns, generator(1)).tests


def test_a_rule_without_a_p_value_holds_or_not():
    made = {"name": "n", "question": "shape", "recommended": False}
    assert TestResult(**made, p_value=None, holds=True).rejects
    assert not TestResult(**made, p_value=None).rejects
    assert TestResult(**made, p_value=0.049).rejects
    assert not TestResult(**made, p_value=0.05).rejects


def test_a_dose_that_is_no_number_is_refused_and_a_negative_one_is_a_dose():
    columns = drawn("no-effect")
    lowest = replace(columns, dose=np.where(columns.dose == 0, -0.1, columns.dose))
    assert [one.p_value for one in infer(lowest, generator(1)).tests]
    for wrong in (float("nan"), float("inf")):
        with pytest.raises(BadValue, match="a finite number"):
            infer(replace(columns, dose=np.where(columns.dose == 0, wrong, columns.dose)), generator(1))


@pytest.mark.parametrize("p", [(0.0, 1e-6, 1.0), (0.0, 1e-6, 2e-6, 1.0), (0.0, 0.5, 0.500001)])
def test_values_of_p_that_lie_close_together_are_tested_all_the_same(p):
    columns = simulate_outcomes(
        replace(WORLDS["no-effect"], success=(0.5,) * len(p), trap=(0.0,) * len(p)), Design(p=p), generator(3)
    )
    assert all(test.p_value is None or 0 <= test.p_value <= 1 for test in infer(columns, generator(1)).tests)
