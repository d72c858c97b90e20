"""Boxes are given out in balance, orders too, and nobody meets the same luck twice, nor a box that a rule of places opens."""

from collections import Counter
from itertools import pairwise
from math import ceil, comb

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from seated import people_study, short, under

from lockprobe.boxes.solve import optimum
from lockprobe.people.assignment import assigned, boxes_each, conditions_of, practice_plan, trials_for
from lockprobe.people.diary import Diary, Did, Joined
from lockprobe.people.experiment import Experiment
from lockprobe.studies.options.studyfile import study as study_from

CONDITIONS = (
    "truth", "flip?p=0.4", "flip?p=0.4 + nudge", "drop?p=1", "tremble?p=0.1", "tremble?p=0.2", "flip?p=0.4 + warn",
)  # fmt: skip
"""Several have the same flip rate, or none: an order that went by flip rates would be out of balance."""


def study_of(conditions, repetitions=1, trials=4, seed=7):
    return under(*CONDITIONS[:conditions], repetitions=repetitions, trials=trials, seed=seed)


def diary_of(slots, kept):
    """Of somebody who got these trials, and whose other boxes broke."""
    joined = Joined(identity="a", token="", at=0.0, platform={}, slots=slots, words="")
    broken = [box for box, slot in enumerate(slots, 1) if slot not in kept]
    return Diary(joined, [Did(at=0.0, turn=2, scene="box", act=None, box=box, ended="error") for box in broken])


def joining(study, experiment, people=None, leave=lambda number, slots: slots, taken=()):
    """The trials of so many who join one after the other, or of all there is room for; and those that they keep."""
    given, gone = [], {(one.condition, one.repetition, one.trial) for one in taken}
    while (people is None or len(given) < people) and (slots := assigned(study, experiment, given, gone)):
        given.append(diary_of(slots, leave(1 + len(given), slots)))
    return [one.joined.slots for one in given], [one.slots_kept for one in given]


def spread(counts, among):
    """The difference between the most and the least of some counts."""
    numbers = [counts[one] for one in among]
    return max(numbers) - min(numbers)


@settings(max_examples=20)
@given(
    conditions=st.integers(1, 7),
    repetitions=st.integers(1, 3),
    trials=st.integers(1, 6),
    each=st.none() | st.integers(1, 12),
)
def test_every_trial_is_given_out_once_nobody_meets_a_luck_twice_and_conditions_are_even(
    conditions, repetitions, trials, each
):
    study, experiment = study_of(conditions, repetitions, trials), short(trials_each=each)
    people, _ = joining(study, experiment)
    slots = [slot for theirs in people for slot in theirs]
    assert len(slots) == len(set(slots)) == conditions * repetitions * trials
    played, length = Counter(), boxes_each(study, experiment)
    for theirs in people:
        assert len({(slot.repetition, slot.trial) for slot in theirs}) == len(theirs)
        assert len(theirs) <= length
        played.update(slot.condition for slot in theirs)
        if len(theirs) == length:  # after that not enough is left
            assert spread(played, conditions_of(study)) <= 1


@settings(max_examples=12)
@given(conditions=st.integers(2, 7), seed=st.integers(0, 50), rounds=st.integers(1, 2))
@example(conditions=5, seed=3, rounds=2)
def test_each_condition_stands_equally_often_in_each_place_and_after_each_other(conditions, seed, rounds):
    people, _ = joining(study_of(conditions, trials=2 * conditions, seed=seed), short(), rounds * conditions)
    stood = Counter((place, slot.condition) for slots in people for place, slot in enumerate(slots))
    assert (set(stood.values()), len(stood)) == ({rounds}, conditions**2)
    after = Counter((one.condition, two.condition) for slots in people for one, two in pairwise(slots))
    if rounds == 2 or conditions % 2 == 0:  # an odd number takes twice as many orders
        assert (set(after.values()), len(after)) == ({rounds}, conditions * (conditions - 1))


@settings(max_examples=12)
@given(taken=st.sets(st.integers(0, 23)), people=st.integers(0, 3))
@example(taken={*range(15), 17, 19, 22, 23}, people=3)
def test_what_is_taken_is_left_alone_and_the_same_is_given_for_the_same(taken, people):
    study = study_of(4, trials=6)
    every = [slot for slots in joining(study, short())[0] for slot in slots]
    gone = [every[i] for i in taken]
    first, second = (joining(study, short(), people + 1, taken=gone)[0] for _ in range(2))
    assert first == second
    found = [slot for slots in first for slot in slots]
    assert len(found) == len(set(found))
    assert not set(found) & set(gone)
    assert found or len(gone) == len(every)


def test_who_withdraws_leaves_a_hole_that_is_filled_first_and_another_seed_gives_other_orders():
    study = study_of(4, trials=4)
    people, _ = joining(study, short(), 3)
    without = [diary_of(slots, slots) for slots in (people[0], people[2])]
    assert [slot.condition for slot in assigned(study, short(), without)] == [slot.condition for slot in people[1]]
    first = [joining(study_of(5, trials=9, seed=seed), short(), 1)[0][0] for seed in range(12)]
    assert len({tuple(slot.condition for slot in slots) for slots in first}) > 6


@pytest.mark.parametrize(
    "leave",
    [
        lambda number, slots: slots[:1],
        lambda number, slots: slots[:1] if number % 2 else slots,
        lambda number, slots: tuple(slot for slot in slots if slot.condition != "flip?p=0.4 + nudge"),  # always breaks
    ],
)
def test_orders_stay_balanced_whatever_people_leave(leave):
    people, _ = joining(study_of(4, trials=40), short(), 24, leave)
    assert set(Counter(tuple(slot.condition for slot in slots) for slots in people).values()) == {6}


@settings(max_examples=10)
@given(conditions=st.integers(2, 6), each=st.integers(1, 5), luck=st.randoms(use_true_random=False))
def test_what_people_leave_is_made_up_for_where_each_plays_only_some(conditions, each, luck):
    each, study = min(each, conditions - 1), study_of(conditions, trials=60)
    people, kept = joining(study, short(trials_each=each), 20, lambda _, slots: slots[: luck.randint(1, each)])
    assert all(len({slot.condition for slot in slots}) == each for slots in people)
    assert spread(Counter(slot.condition for slots in kept for slot in slots), conditions_of(study)) <= each + 1
    stood = Counter((place, slot.condition) for slots in joining(study, short(trials_each=each), conditions)[0] for place, slot in enumerate(slots))  # fmt: skip
    assert max(stood.values()) <= 2


@pytest.mark.parametrize(("conditions", "each"), [(4, 2), (5, 2), (6, 2), (4, 3), (6, 3)])
def test_where_not_all_are_played_every_combination_is(conditions, each):
    people, _ = joining(study_of(conditions, trials=60), short(trials_each=each), 60)
    assert len({frozenset(slot.condition for slot in slots) for slots in people}) == comb(conditions, each)


FIXED = {"box": "chain-4", "layout": "fixed"}, Experiment(practice="chain-3")


def persons(asked=None, experiment=None, p=(0, 0.4), people=80):
    """The practice box and the boxes of each person, on their panels."""
    asked, experiment = asked or {}, experiment or Experiment()
    luck = trials_for(people, len(p), 1, experiment)
    planned = study_from("flips", agent="participant", p=list(p), repetitions=1, trials=luck, **asked)
    planned = study_from(
        "flips", agent="participant", p=list(p), repetitions=1, trials=ceil(luck / len(planned.boxes)), **asked
    )
    for person, slots in enumerate(joining(planned, experiment, people)[0]):
        identity = f"{person:08x}"
        theirs = diary_of(slots, slots)
        boxes = [theirs.plan(planned, box).box for box, _ in enumerate(slots, 1)]
        yield practice_plan(planned, experiment, identity).box, boxes


def steps_from_right(box, budget):
    """The steps in which a box opens whose joints are attempted from right to left, again and again."""
    order = sorted(range(len(box.joints)), key=lambda joint: box.joints[joint].place, reverse=True)
    here = box.initial
    for step in range(budget):
        here, moved = box.attempt(here, joint := order[step % len(order)])
        if moved and joint == box.target_index:
            return step + 1
    return budget


def test_a_rule_of_places_opens_no_more_boxes_than_luck_does():
    least = [steps_from_right(box, 20) == optimum(box) for _, boxes in persons() for box in boxes]
    assert np.mean(least) < 0.08  # one order of 24
    assert {steps_from_right(box, 20) for _, boxes in persons(*FIXED) for box in boxes} == {4}


@pytest.mark.parametrize(
    ("people", "p", "how"),
    [(40, (0, 0.2, 0.4, 0.6), {}), (37, (0, 0.2, 0.4), {}), (40, (0, 0.4), {"trials_each": 8}),
     (60, (0, 0.4), {"trials_each": 1})],
)  # fmt: skip
def test_nobody_plays_a_box_twice_and_boxes_are_balanced_over_conditions_and_positions(people, p, how):
    experiment = Experiment(**how)
    trials = ceil(trials_for(people, len(p), 1, experiment) / 8)
    planned = study_from("flips", agent="participant", p=list(p), repetitions=1, trials=trials)
    conditions, positions = Counter(), Counter()
    for slots in joining(planned, experiment, people)[0]:
        boxes = [planned.box_of(slot.trial).name for slot in slots]
        assert len({*boxes}) == len(boxes) == boxes_each(planned, experiment)
        conditions.update((slot.condition, box) for slot, box in zip(slots, boxes, strict=True))
        positions.update(enumerate(boxes))
    assert len(conditions) == 8 * len(p)
    assert max(conditions.values()) - min(conditions.values()) <= 1
    assert max(positions.values()) - min(positions.values()) <= 2


def test_the_practice_is_another_box_in_which_no_condition_acts_and_no_picture_is_degraded():
    planned = people_study(p=(0.4,), max_steps=9)
    plan = practice_plan(planned, Experiment(practice="chain-2"))
    assert (plan.condition.specs, plan.box.name, plan.budget) == ((), "chain-2", 9)
    assert plan.modality == planned.modalities[0]
    assert plan.seed != planned.seed
    acting = under("flip?p=1", "nudge + tremble?p=1", "warn", "delay?lag=2", "drop?p=1")
    assert practice_plan(acting, Experiment()).condition.specs == ()
    pictured = under("rgb?blur=8", "nudge + rgb?blur=4&occlude=0.3", plant="fast-twin")
    assert practice_plan(pictured, Experiment()).condition.modality == "rgb"


def test_everybody_practises_on_a_panel_of_their_own():
    planned = study_from("flips", agent="participant")
    plans = [practice_plan(planned, Experiment(), f"{person:08x}") for person in range(60)]
    assert {plan.box.name for plan in plans} == {"common-cause-3"}
    places = Counter(plan.box.joints[plan.box.target_index].place for plan in plans)
    assert len(places) == 4
    assert max(places.values()) < 30
    assert plans[0] == practice_plan(planned, Experiment(), f"{0:08x}")
