"""Agents compared: rows counted by hand, families, what is said of two agents, and every pair in the figure."""

import pytest
from builders import SOLUTION, make_trial, small_study, write_study
from reported import tables_of

from lockprobe.report.opened import open_study
from lockprobe.report.page import Page
from lockprobe.report.questions import agents_compared
from lockprobe.report.results import results_of as made_of
from lockprobe.statistics.agents import CHANGE, STEPS, SUCCESS, compared
from lockprobe.statistics.course import cells_of, courses

P = (0.0, 0.4)
FAILED = (0,) * 20
(SECTION,) = agents_compared.SECTIONS


def of_trials(directory, *trials, p=P):
    """The results of a study that was played so."""
    agents = dict.fromkeys(trial.group for trial in trials)
    planned = small_study(tuple(agents), p, 1, max(trial.trial for trial in trials))
    return made_of(open_study(write_study(directory / "study", planned, list(trials))))


def some(agent, *solved, of=10, fast=SOLUTION, slow=FAILED, p=P):
    """So many trials that are solved in this way at each p, and all others in the other way."""
    return [
        make_trial(fast if i < n else slow, agent=agent, p=rate, trial=i + 1)
        for rate, n in zip(p, solved, strict=True)
        for i in range(of)
    ]


def table(found):
    head, *rows = tables_of(found)["comparisons"] or [[]]
    return [dict(zip(head, row, strict=True)) for row in rows]


def said(found):
    (part,) = SECTION.show(found)
    return part.answer


def test_pairs_are_compared_over_all_flip_rates(tmp_path):
    solved = {"llm:acme/one": (9, 8), "llm:acme/two": (3, 10), "random": (2, 2), "round-robin": (10, 10)}
    found = of_trials(tmp_path, *(trial for agent, n in solved.items() for trial in some(agent, *n)))
    rows = table(found)
    assert (len(rows), "under" in rows[0]) == (3, False)
    assert [rows[0][name] for name in ("agent", "trials", "success of both")] == ["llm:acme/one", "20", "85 % and 65 %"]
    more = "llm:acme/one solves more than random, llm:acme/two solves more than random"
    assert said(found) == f"Over all flip rates, a difference was detected for 2 of 3 pairs of agents: {more}."
    found = of_trials(tmp_path / "two", *some("llm:a", 9, 2), *some("llm:b", 9, 9))
    assert said(found).endswith(" was detected for 1 of 1 pairs of agents: llm:b solves more than llm:a.")


def test_p_values_are_corrected_by_family_as_statsmodels_does(tmp_path):
    from statsmodels.stats.multitest import multipletests

    solved = {"llm:a": (20, 14), "llm:b": (11, 11), "llm:c": (2, 2), "llm:d": (2, 2), "random": (1, 1)}
    trials = [trial for agent, n in solved.items() for trial in some(agent, *n, of=20)]
    trials += some("human-inspired", 6, 6, of=20, slow=(1,) * 20)
    found, pairs = of_trials(tmp_path, *trials), compared(courses(cells_of(trials).values()))

    def holm(tests):
        tested = [p for p in tests if p is not None]
        return [None if p is None else c for p, c in zip(tests, multipletests(tested, method="holm")[1], strict=True)]

    for family, baseline in (("agents", False), ("agents and baselines", True)):
        own = [one for one in pairs if one.baseline is baseline]
        for name in (SUCCESS, STEPS):
            for one, p_value in zip(own, holm([one.mean(name).p_value for one in own]), strict=True):
                row = found.one(name, agent=one.second.agent, versus=one.first.agent, family=family)
                assert row.p_value == (None if one.plays_alike else pytest.approx(p_value))
                assert row.corrected_for == (1 if one.plays_alike else len(own))
    changes = holm([min(of.p_value for of in one.changes.values()) for one in pairs[:5]])
    rows = [found.get(CHANGE, agent=one.second.agent, versus=one.first.agent) for one in pairs]
    assert [row.p_value for row in rows[:5]] == pytest.approx(changes)
    assert rows[5:] == [None] * 9  # the last two agents play alike, and baselines have no change
    alike = [row["conclusion"] for row in table(found) if (row["agent"], row["compared with"]) == ("llm:c", "llm:d")]
    assert alike == ["play alike"]


def test_one_agent_has_nobody_beside_it(tmp_path):
    found = of_trials(tmp_path, *some("llm:a", 9, 8))
    assert 'id="agents_compared"' not in Page(found=found).text()
    assert table(found) == []
