"""People as one agent: who played, first boxes apart, and the other analyses that take them together by person."""

import random
from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, play_study, played_by_people, small_study

from lockprobe.statistics.course import cells_of, courses

STUDY = small_study(("participant", "random"), (0.0, 0.3, 0.6), 2, 4)


def person(identity, solved, *, position=1, p=0.0, trial=1, **facts):
    made = make_trial(SOLUTION if solved else (0,) * 20, agent=f"participant:{identity}", p=p, trial=trial)
    return replace(made, key=made.key.replace(f":{identity}", ""), facts={"position": position, **facts})


@pytest.fixture(scope="module")
def played():
    return [*played_by_people(STUDY, 3), *play_study(small_study(("random",), STUDY.p, 2, 4))]


def test_people_are_one_agent_and_order_does_not_matter(played):
    people, agent = courses(cells_of(played).values())
    assert (people.agent, people.people, agent.agent) == ("participant", True, "random")
    shuffled = list(played)
    random.Random(1).shuffle(shuffled)
    again = next(one for one in courses(cells_of(shuffled).values()) if one.people)
    assert [again.outcomes.at(again.outcomes.dose == p).solved.sum() for p in STUDY.p] == [
        people.outcomes.at(people.outcomes.dose == p).solved.sum() for p in STUDY.p
    ]
    (alone,) = courses(cells_of([trial for trial in played if trial.group == "random"]).values())
    assert (alone.trials, alone.doses, alone.family) == (agent.trials, agent.doses, agent.family)


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
