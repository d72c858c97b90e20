"""Courses: which trials tests are of, which agents are judged together, and which play alike whatever they are told."""

from dataclasses import replace

from builders import SOLUTION, make_trial

from lockprobe.statistics.course import cells_of, courses
from lockprobe.statistics.outcomes import BlockOrder, Point, joined, never_acted, outcomes, plays_alike, points


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
    once = [make_trial((3, 2, 1, 0), p=p, trial=t, false_at=(3,) if p else ()) for p in (0.0, 0.4) for t in range(10)]
    assert plays_alike(once)  # the last report but one is followed by an action


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


BROKE = [
    make_trial(SOLUTION, trial=1),
    make_trial([0, 1, 2, 0, 1, 2], trial=2, budget=6),
    make_trial([0, 1], trial=3, broken="model"),
    make_trial([0, 1, 2, 0, 1, 2, 3], trial=1, repetition=2, broken="reply"),
]


def test_broken_trials_are_completed_by_a_success_at_once_or_by_none_in_all_of_the_budget():
    soon, never = (outcomes(BROKE).completed(one) for one in (True, False))
    assert soon.solved.tolist() == [True, False, True, True]
    assert soon.length.tolist() == [4, 6, 3, 8]
    assert soon.onset.tolist() == [0, 6, 3, 6]
    assert never.solved.tolist() == [True, False, False, False]
    assert never.length.tolist() == [4, 6, 20, 20]
    assert never.onset.tolist() == [0, 6, 0, 6]
    assert (len(soon.broke), len(never.ended)) == (0, 4)
    mixed = outcomes(BROKE).completed([False, True, False, True])
    assert (mixed.length.tolist(), mixed.solved.tolist()) == ([4, 6, 20, 8], [True, False, False, True])
    late = joined([outcomes(BROKE[:2]), outcomes(BROKE[2:])])
    assert late.at_ended_doses.dose.tolist() == [0, 0]


def test_groups_are_joined_with_their_doses_and_points_are_shares_of_repetitions():
    person = replace(make_trial(SOLUTION, agent="participant:a"), facts={})
    both = joined([outcomes(BROKE), outcomes([person, person])], [0.4, 0])
    assert both.dose.tolist() == [0.4] * 4 + [0] * 2
    assert both.crossed
    assert both.player.tolist() == [""] * 4 + ["participant:a"] * 2
    assert both.cluster.tolist() == [0, 1, 2, 3, 4, 4]
    assert both.luck.tolist() == [0, 1, 2, 3, 0, 0]
    assert points(both.ended) == [Point(0.0, 1, 2, 1.0, 0.0), Point(0.4, 1, 2, 0.5, 0.5)]


def test_blocks_of_an_earlier_plan_come_first():
    order = BlockOrder(plans=((1, 2), (2, 2), (2, 3)))
    assert order.rank([1, 1, 2, 2, 1, 2], [1, 2, 1, 2, 3, 3]).tolist() == [0, 1, 2, 3, 4, 5]
