"""Times of people's choices: quartiles by condition, of what is on record and of nobody else's trials."""

from builders import SOLUTION, make_trial

from lockprobe.statistics.response_times import response_times


def played(p, trial, agent="participant:aaaa01", **more):
    return make_trial(SOLUTION, agent=agent, p=p, trial=trial, **more)


def times_of(*trials):
    return {(trial.key, step.step): 100.0 * trial.trial + step.step for trial in trials for step in trial.steps}


def test_quartiles_by_hand():
    one = played(0.0, 1)
    steps = len(one.steps)
    (found,) = response_times([one], {(one.key, step): float(step**2) for step in range(1, steps + 1)})
    squares = [step**2 for step in range(1, steps + 1)]
    assert (found.condition, found.choices, found.first) == ("truth", steps, 1.0)
    assert squares[0] < found.low < found.median < found.high < squares[-1]
    middle = sorted(squares)[(steps - 1) // 2 : steps // 2 + 1]
    assert found.median == sum(middle) / len(middle)


def test_conditions_stand_apart_and_then_together():
    low, high = played(0.0, 1), played(0.4, 2)
    found = response_times([high, low], times_of(low, high))
    assert [one.condition for one in found] == ["truth", "flip?p=0.4", ""]
    assert [one.first for one in found] == [101.0, 201.0, 151.0]
    assert found[2].choices == found[0].choices + found[1].choices


def test_only_people_whose_trials_ended_and_whose_times_are_known():
    agent, unknown = played(0.0, 1, agent="random"), played(0.4, 1)
    assert response_times([agent, unknown], times_of(agent)) == ()
    broken = make_trial(SOLUTION[:2], agent="participant:aaaa01", broken="plant")
    assert response_times([broken], times_of(broken)) == ()


def test_without_the_first_choice_its_time_is_not_known():
    one = played(0.0, 1)
    (found,) = response_times([one], {(one.key, 2): 700.0})
    assert (found.choices, found.median, found.first) == (1, 700.0, None)
