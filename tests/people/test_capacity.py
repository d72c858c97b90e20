"""How many people a study has places for, and what each of them plays."""

import pytest
from seated import people_study, short

from lockprobe.foundation.errors import UserMistake
from lockprobe.people.assignment import Given, assigned, boxes_each
from lockprobe.people.capacity import capacity_of, check_capacity, trials_for, what_each_plays


def whole(study, experiment):
    """How many really get as many boxes as asked for, one after the other."""
    given, people = Given(), 0
    while len(slots := assigned(study, experiment, given)) == boxes_each(study, experiment) and slots:
        given.give(slots)
        people += 1
    return people


@pytest.mark.parametrize("conditions", [1, 2, 3, 4])
@pytest.mark.parametrize("trials", [4, 7])
@pytest.mark.parametrize("design", ["within", "between"])
@pytest.mark.parametrize("each", [None, 1, 2])
def test_as_many_fit_as_is_said(conditions, trials, design, each):
    study = people_study(p=tuple(n / 8 for n in range(conditions)), repetitions=1, trials=trials)
    experiment = short(design=design, trials_each=each)
    assert whole(study, experiment) == capacity_of(study, experiment).people


@pytest.mark.parametrize("people", [1, 3, 40])
@pytest.mark.parametrize("conditions", [2, 4])
@pytest.mark.parametrize("repetitions", [1, 3])
@pytest.mark.parametrize(
    "settings", [{}, {"design": "between"}, {"trials_each": 2}, {"design": "between", "trials_each": 3}]
)
def test_with_the_trials_that_are_worked_out_they_fit(people, conditions, repetitions, settings):
    experiment = short(participants=people, **settings)
    trials = trials_for(people, conditions, repetitions, experiment)
    study = people_study(p=tuple(n / 8 for n in range(conditions)), repetitions=repetitions, trials=trials)
    check_capacity(study, experiment)
    assert capacity_of(study, experiment).people >= people


def test_more_people_than_places_are_refused_with_what_helps():
    study = people_study(trials=18)
    with pytest.raises(UserMistake, match=r"got 40, expected at most 18, .*give --trials 40"):
        check_capacity(study, short(participants=40))
    check_capacity(study, short(participants=18))


def test_fewer_trials_than_conditions_are_refused_where_everybody_plays_each():
    study = people_study(trials=1)
    with pytest.raises(UserMistake, match=r"got 1, expected at least 2, the number of conditions; give --trials 2"):
        check_capacity(study, short())
    for other in (short(trials_each=1), short(design="between")):
        check_capacity(study, other)


def test_what_each_plays_is_said():
    study = people_study(trials=6)
    assert what_each_plays(study, short()) == (
        "Places for 6 people, each plays 2 boxes: each of the 2 conditions once, up to 12 steps a box.",
    )
    (places, balance) = what_each_plays(study, short(participants=5))
    assert places.startswith("Places for 5 people of 6,")
    assert balance == "Orders of the conditions are balanced after every 2 people; 5 are 1 over."
    assert "not every one of the 2 conditions" in what_each_plays(study, short(trials_each=1))[0]
    assert "1 box of one condition of 2" in what_each_plays(study, short(design="between"))[0]
