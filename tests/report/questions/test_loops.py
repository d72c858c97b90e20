"""Action loops: their rates beside chance, from the rows of a study to its page."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, small_study
from reported import found_in

from lockprobe.report.page import Page, tables_of
from lockprobe.report.rows import Results
from lockprobe.statistics.loops.chance import chance_level


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> Results:
    return found_in(tmp_path_factory.mktemp("loops"), small_study(("random", "cognitive:perseverant")))


def test_every_loop_rate_stands_beside_two_levels_of_chance(found):
    for cell in found.cells:
        uniform, no_repeat = (cell.value("loop_rate", of) for of in ("uniform", "no-repeat"))
        assert uniform <= no_repeat
        rate = cell.get("loop_rate")
        assert 0 <= rate.low <= rate.value <= rate.high <= 1
        assert rate.value == pytest.approx(sum(one.value * one.n for _, one in cell.points) / rate.n)
    head, *rows = tables_of(found)["conditions"]
    assert [row[1] for row in rows] == ["every flip rate", "0", "0.3", "0.6"]  # a blind agent once
    assert {"loop rate", "by chance"} <= {*head}


def test_numbers_of_known_trials(tmp_path):
    """Chance is that of exactly these lengths; simulated where it cannot be counted, and then with an interval."""
    played = [[0, 1, 0, 0, 0, 1, 0] + [1] * 13, SOLUTION]
    trials = [make_trial(one, agent="llm:x", trial=i) for i, one in enumerate(played, 1)]
    trials += [make_trial([0] * 3, agent="llm:x", trial=3, broken="model")]
    (cell,) = found_in(tmp_path / "exact", small_study(("llm:x",), (0.0,), 1, 3), trials).cells
    assert (cell.value("loop_rate"), cell.get("loop_rate").n) == (1 / 2, 2)
    assert cell.value("loop_rate", "uniform") == pytest.approx(chance_level(20).probability / 2)
    assert cell.value("loop_rate", "no-repeat") == pytest.approx(chance_level(20, null="no-repeat").probability / 2)
    assert cell.get("loop_rate", "uniform").low is None
    long = [make_trial([0, 1, 2] * 9, agent="llm:x", budget=27)]
    (cell,) = found_in(tmp_path / "long", replace(small_study(("llm:x",), (0.0,), 1, 1), max_steps=27), long).cells
    level = cell.get("loop_rate", "uniform")
    assert level.note == "simulation"
    assert 0 < level.low < level.value < level.high <= 1


@pytest.mark.parametrize(("loops", "said"), [(12, "more than the"), (0, "less than the"), (9, "not told from the")])
def test_the_interval_has_to_lie_outside_both_levels_of_chance(tmp_path, loops, said):
    """Of 12 trials of 12 steps, in which random actions loop in 31 to 48 %."""
    played = [[0, 1, 2] * 4 if i < loops else [0] * 5 + [1] * 5 + [0] * 2 for i in range(12)]
    trials = [make_trial(one, agent="llm:x", trial=i, budget=12) for i, one in enumerate(played, 1)]
    found = found_in(tmp_path, replace(small_study(("llm:x",), (0.0,), 1, 12), max_steps=12), trials)
    assert f" % ({said} 31 to 48 % by chance)" in Page(found=found).text()
