"""All tests of one agent: every question answered by one test, and nothing made up."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from known_truth import WORLDS, simulated

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.report.prose.hypothesis_tests import limits_said
from lockprobe.simulation.power.simulate import BUDGET
from lockprobe.simulation.power.worlds import Design
from lockprobe.statistics.inference.difference import any_difference
from lockprobe.statistics.inference.infer import infer
from lockprobe.statistics.outcomes import Outcomes, outcomes


def drawn(name, seed=1, design=None):
    return simulated(name, generator(seed, name), design)[0]


@pytest.mark.parametrize("name", WORLDS)
def test_every_question_has_one_test(name):
    found = infer(drawn(name), generator(1))
    for test in found.tests:
        assert 0 < test.p_value <= 1
    assert len({test.question for test in found.tests}) == len(found.tests) == 5
    json.dumps(asdict(found), allow_nan=False)


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
        if test.p_value is None:
            assert limits_said(test)


def test_a_dose_that_is_no_number_is_refused_and_a_negative_one_is_a_dose():
    columns = drawn("no-effect")
    lowest = replace(columns, dose=np.where(columns.dose == 0, -0.1, columns.dose))
    assert [one.p_value for one in infer(lowest, generator(1)).tests]
    for wrong in (float("nan"), float("inf")):
        with pytest.raises(BadValue, match="a finite number"):
            infer(replace(columns, dose=np.where(columns.dose == 0, wrong, columns.dose)), generator(1))


@pytest.mark.parametrize("p", [(0.0, 1e-6, 1.0), (0.0, 1e-6, 2e-6, 1.0), (0.0, 0.5, 0.500001)])
def test_values_of_p_that_lie_close_together_are_tested_all_the_same(p):
    columns, _ = simulated("no-effect", generator(3), Design(p=p), success=(0.5,) * len(p), trap=(0.0,) * len(p))
    assert all(test.p_value is None or 0 <= test.p_value <= 1 for test in infer(columns, generator(1)).tests)


def _rejected(name):
    """How often each test rejects of a hundred studies, and the truth: question -> rejections."""
    seen = dict.fromkeys(("success", "speed", "shape", "looping", "looping again"), 0)
    for number in range(STUDIES):
        ended, broken = simulated(name, generator(number, name))
        for test in infer(ended, generator(number, name, "tests"), broken=broken, budget=BUDGET).tests:
            seen[test.question] += test.rejects
    return seen


STUDIES = 100


@pytest.mark.parametrize("name", WORLDS)
def test_tests_that_we_conclude_from_keep_their_error_rate(name):
    """Where the truth is no, 13 rejections of 100 have a probability below 0.002 at 5 %; where loops trap, most reject."""
    seen, truths = _rejected(name), WORLDS[name].truths
    assert {question: k for question, k in seen.items() if question not in truths and k > 12} == {}
    if name == "loop-trapped":
        assert seen["looping"] > 60


@pytest.mark.parametrize("name", ["no-effect", "unequal-luck", "saturating", "inverted-u"])
def test_no_interval_of_the_differences_leaves_out_the_truth(name):
    """Of all six differences of a study together: in at most 5 % of studies, and of 100 in at most 12."""
    truth, missed = WORLDS[name].success, 0
    for number in range(STUDIES):
        found = any_difference(drawn(name, number), generator(number), 99)
        missed += any(not one.low <= t - truth[0] <= one.high for one, t in zip(found.at, truth[1:], strict=True))
    assert missed <= 12
