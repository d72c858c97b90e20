"""Agents compared: what is said of two agents, of all pairs, and of one alone."""

from builders import SOLUTION, make_trial, small_study
from reported import found_in, tables_of

from lockprobe.report.page import Page
from lockprobe.report.questions import agents_compared

P = (0.0, 0.4)


def played(directory, solved):
    """The results of agents of which so many of ten trials are solved at each flip rate."""
    trials = [
        make_trial(SOLUTION if i < n else (0,) * 20, agent=agent, p=p, trial=i + 1)
        for agent, of in solved.items()
        for p, n in zip(P, of, strict=True)
        for i in range(10)
    ]
    return found_in(directory, small_study(solved, P, 1, 10), trials)


def said(found):
    (part,) = agents_compared.SECTIONS[0].show(found)
    return part.answer


def test_pairs_are_compared_over_all_flip_rates(tmp_path):
    solved = {"llm:acme/one": (9, 8), "llm:acme/two": (3, 10), "random": (2, 2), "round-robin": (10, 10)}
    found = played(tmp_path, solved)
    head, *rows = tables_of(found)["comparisons"]
    row = dict(zip(head, rows[0], strict=True))
    assert (len(rows), "under" in head) == (3, False)
    assert [row[name] for name in ("agent", "trials", "success of both")] == ["llm:acme/one", "20", "85 %, 65 %"]
    more = "llm:acme/one solves more than random, llm:acme/two solves more than random"
    assert said(found) == f"Over all flip rates, a difference was detected for 2 of 3 pairs of agents: {more}."
    found = played(tmp_path / "two", {"llm:a": (9, 2), "llm:b": (9, 9)})
    assert said(found).endswith(" was detected for 1 of 1 pairs of agents: llm:b solves more than llm:a.")


def test_one_agent_has_nobody_beside_it(tmp_path):
    found = played(tmp_path, {"llm:a": (9, 8)})
    assert 'id="agents_compared"' not in Page(found=found).text()
    assert tables_of(found)["comparisons"] == []


def test_agents_that_play_alike_are_said_to_and_have_no_test(tmp_path):
    found = played(tmp_path, {"llm:a": (2, 7), "llm:b": (2, 7), "llm:c": (9, 9)})
    head, *rows = tables_of(found)["comparisons"]
    assert [row[head.index("conclusion")] == "play alike" for row in rows] == [True, False, False]
    pairs = found.where("success_difference", family="agents")
    assert [(row.p_value is None, row.corrected_for) for row in pairs] == [(True, 1), (False, 3), (False, 3)]
