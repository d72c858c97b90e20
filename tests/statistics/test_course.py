"""Courses: which trials tests are of, which agents are judged together, and which play alike whatever they are told."""

from dataclasses import replace

from builders import SOLUTION, make_trial, play_study, small_study

from lockprobe.statistics.course import cells_of, courses
from lockprobe.statistics.idle import never_acted
from lockprobe.statistics.outcomes import plays_alike


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


def alike(reports, **more):
    """Trials told the truth and lied to in the first of their steps, acted in alike."""
    return [
        make_trial((3, 2, 1, 0), agent="llm:local", p=p, trial=t, **more | {"false_at": (1,) if p else ()})
        for p in (0.0, 0.4)
        for t in range(reports)
    ]


def test_an_agent_is_blind_if_ten_reports_differed_and_none_of_its_actions():
    assert not plays_alike(alike(9))
    assert plays_alike(alike(10))
    heeds = make_trial((3, 1, 2, 0), agent="llm:local", p=0.4, trial=0, false_at=(1,))
    assert not plays_alike([*alike(10)[:-1], heeds])
    last = [replace(trial, steps=trial.steps[:1]) for trial in alike(30)]  # nobody knows what it would have done next
    assert not plays_alike(last)


def test_people_are_never_taken_for_blind():
    """Three people who act alike at three p, though they were told otherwise, are no agent that does not listen."""
    own = [
        replace(
            make_trial((0, *SOLUTION), agent=f"participant:{i:04d}", p=i / 10, trial=t, false_at=[1] * (i > 0)),
            facts={},
        )
        for i in range(3)
        for t in range(10)
    ]
    assert not courses(cells_of(own).values())[0].blind
    assert courses(cells_of([replace(trial, agent="llm:a") for trial in own]).values())[0].blind
