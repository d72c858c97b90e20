"""Agents compared: every two of them on the same boxes."""

import pytest
from builders import SOLUTION, make_trial, small_study, write_study

from lockprobe.report.opened import open_study
from lockprobe.report.page import page_of, tables_of
from lockprobe.report.questions import agents_compared
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers

P = (0.0, 0.4)
SOLVED = {"llm:acme/one": (9, 8), "llm:acme/two": (3, 10), "random": (2, 2), "round-robin": (10, 10)}
TABLES = [table for one in agents_compared.SECTIONS for table in one.tables]


def trials(agent):
    """Trials that are solved at once or not at all."""
    for p, solved in zip(P, SOLVED[agent], strict=True):
        for i in range(10):
            joints = SOLUTION if i < solved else (0,) * 20
            yield make_trial(joints, agent=agent, p=p, trial=i + 1)


def opened(directory, *agents):
    """A study of these agents."""
    made = [trial for agent in agents for trial in trials(agent)]
    return open_study(write_study(directory / "study", small_study(agents, P, 1, 10), made))


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return opened(tmp_path_factory.mktemp("side"), *SOLVED)


@pytest.fixture(scope="module")
def found(study):
    return results_of(study_numbers(study))


def results(directory, *agents):
    return results_of(study_numbers(opened(directory, *agents)))


def table(found, name):
    head, *rows = tables_of(found, TABLES)[name]
    return [dict(zip(head, row, strict=True)) for row in rows]


def test_pairs_are_compared_and_changes_with_noise(found):
    pairs = [(row.agent, row.versus, row.family) for row in found.where("played_by_one_only")]
    assert pairs == [
        ("llm:acme/one", "llm:acme/two", "agents"),
        ("llm:acme/one", "random", "agents and baselines"),
        ("llm:acme/two", "random", "agents and baselines"),
    ]
    (first, *_) = rows = table(found, "comparisons")
    assert len(rows) == 3
    assert [first[name] for name in ("agent", "pairs of trials", "success", "success of the other")] == [
        *("llm:acme/one", "20", "85 %", "65 %")
    ]
    assert len(table(found, "comparisons-by-p")) == 6
    assert [row["to flip rate"] for row in table(found, "interactions")] == ["all higher, mean", "0.4"]
    (change,) = found.where("success_change_difference", of="")
    assert (change.value, change.control) == (pytest.approx(-0.8), "truth")
    assert found.one("success_change_difference", of="any flip rate").p_value < 0.05


def test_one_agent_has_nobody_beside_it(tmp_path):
    found = results(tmp_path, "llm:acme/one")
    assert found.where("played_by_one_only") == []
    assert 'id="agents_compared"' not in page_of(found)
    assert table(found, "comparisons") == table(found, "interactions") == []
