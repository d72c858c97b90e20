"""Courses: which trials tests are of, and which agents are judged together."""

from dataclasses import replace

from builders import SOLUTION, make_trial, play_study, small_study

from lockprobe.statistics.course import cells_of, courses
from lockprobe.statistics.idle import never_acted


def trials_of(agent, solved, n=6, modality="symbolic"):
    """Trials at each flip rate, of which so many are solved; others fail in another way at every rate."""
    return [
        make_trial(SOLUTION if i < solved[p] else (int(10 * p) % 4, *(0,) * 19), agent=agent, p=p, trial=i + 1,
                   modality=modality)
        for p in solved
        for i in range(n)
    ]  # fmt: skip


def test_agents_under_study_are_one_family_and_baselines_another():
    """Only those that heed what they are told and were played at two rates count."""
    two, one = {0.0: 2, 0.4: 4}, {0.0: 2}
    of = {"llm:a": two, "llm:b": two, "llm:c": two, "llm:d": one, "human-inspired": two}
    found = courses(cells_of([trial for agent, solved in of.items() for trial in trials_of(agent, solved)]).values())
    assert {one.agent: one.family for one in found} == dict.fromkeys(of, 3) | {"human-inspired": 1}


def test_an_agent_that_ignores_reports_is_blind_and_tested_nowhere():
    found = {
        one.agent: (one.blind, {*one.tested.ended.dose.tolist()})
        for one in courses(cells_of(play_study(small_study())).values())
    }
    assert (found["random"], found["human-inspired"]) == ((True, {0.0}), (False, {0.0, 0.3, 0.6}))


def test_a_rate_at_which_no_report_was_false_is_in_no_test():
    idle = {"changed": {"flip?p=0.2": 0}, "changed_steps": 0}
    truthful = [replace(one, **idle) for one in trials_of("llm:a", {0.2: 2}, n=2)]
    (found,) = courses(cells_of([*trials_of("llm:a", {0.0: 1, 0.4: 3}), *truthful]).values())
    assert never_acted(truthful)
    assert found.idle == {0.2}
    assert {*found.tested.ended.dose.tolist()} == {0.0, 0.4}
    assert [*found.by_dose] == [0.0, 0.2, 0.4]
