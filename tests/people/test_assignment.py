"""Boxes are given out in balance, orders too, and nobody meets the same luck twice."""

from collections import Counter
from itertools import pairwise
from math import comb

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from seated import short, under

from lockprobe.people.assignment import Given, boxes_each, conditions_of, williams
from lockprobe.people.assignment import assigned as assigned_after
from lockprobe.people.diary import Slot


def assigned(study, experiment, given, taken, kept=None):
    """What somebody gets who joins after all these."""
    before = Given()
    for number, slots in enumerate(given):
        before.give(slots, None if kept is None else kept[number])
    before.take(taken)
    return assigned_after(study, experiment, before)


def joining(study, experiment, people=None):
    """The trials of so many who join one after the other, or of all there is room for."""
    before = []
    while people is None or len(before) < people:
        slots = assigned(study, experiment, before, {slot for slots in before for slot in slots})
        if not slots:
            break
        before.append(slots)
    return before


def slots_of(study):
    """All trials that people play."""
    for plan in study.plans("participant"):
        yield Slot(condition=plan.label, repetition=plan.repetition, trial=plan.trial)


def leaving(study, experiment, people, leave):
    """So many who join one after the other and leave as ``leave(number, slots)`` says; what they were given, and kept.

    Whoever leaves has gone for good before the next one comes.
    """
    given, kept = [], []
    for number in range(people):
        given.append(assigned(study, experiment, given, {slot for slots in kept for slot in slots}, kept))
        kept.append(leave(number, given[-1]))
    return given, kept


CONDITIONS = (
    "truth", "flip?p=0.4", "flip?p=0.4 + nudge", "drop?p=1", "tremble?p=0.1", "tremble?p=0.2", "flip?p=0.4 + warn",
)  # fmt: skip
"""Several have the same flip rate, or none: an order that went by flip rates would be out of balance."""


def study_of(conditions, repetitions=1, trials=4, seed=7):
    return under(*CONDITIONS[:conditions], repetitions=repetitions, trials=trials, seed=seed)


sizes = {"conditions": st.integers(1, 7), "repetitions": st.integers(1, 3), "trials": st.integers(1, 6)}


@settings(max_examples=60, deadline=None)
@given(**sizes, each=st.none() | st.integers(1, 12), design=st.sampled_from(["within", "between"]))
def test_every_trial_is_given_out_once_and_nobody_meets_a_luck_twice(conditions, repetitions, trials, each, design):
    study, experiment = study_of(conditions, repetitions, trials), short(trials_each=each, design=design)
    people = joining(study, experiment)
    given_out = [slot for slots in people for slot in slots]
    assert sorted(given_out, key=str) == sorted(slots_of(study), key=str)
    for slots in people:
        assert len({(slot.repetition, slot.trial) for slot in slots}) == len(slots) <= boxes_each(study, experiment)
        assert design == "within" or len({slot.condition for slot in slots}) == 1


@settings(max_examples=60, deadline=None)
@given(**sizes, each=st.none() | st.integers(1, 12))
def test_no_condition_is_played_by_more_than_one_more(conditions, repetitions, trials, each):
    study, experiment = study_of(conditions, repetitions, trials), short(trials_each=each)
    people, length = joining(study, experiment), boxes_each(study, experiment)
    played = Counter(dict.fromkeys(conditions_of(study), 0))
    for slots in people:
        if len(slots) == length:  # after that not enough is left
            played.update(slot.condition for slot in slots)
            assert max(played.values()) - min(played.values()) <= 1


@settings(max_examples=60, deadline=None)
@given(**sizes)
def test_between_people_no_condition_has_more_than_one_more(conditions, repetitions, trials):
    study, experiment = study_of(conditions, repetitions, trials), short(design="between")
    has = Counter(dict.fromkeys(conditions_of(study), 0))
    for slots in joining(study, experiment):
        has[slots[0].condition] += 1
        assert max(has.values()) - min(has.values()) <= 1


@settings(max_examples=60, deadline=None)
@given(conditions=st.integers(2, 7), seed=st.integers(0, 50), rounds=st.integers(1, 2))
def test_each_condition_stands_equally_often_in_each_place(conditions, seed, rounds):
    study = study_of(conditions, trials=2 * conditions, seed=seed)
    people = joining(study, short(), rounds * conditions)
    stood = Counter((place, slot.condition) for slots in people for place, slot in enumerate(slots))
    assert set(stood.values()) == {rounds}
    assert len(stood) == conditions**2


@settings(max_examples=60, deadline=None)
@given(conditions=st.integers(3, 7), each=st.integers(1, 6))
def test_where_not_all_are_played_places_are_balanced_too(conditions, each):
    study, experiment = study_of(conditions, trials=10), short(trials_each=each)
    people = joining(study, experiment, conditions)
    stood = Counter((place, slot.condition) for slots in people for place, slot in enumerate(slots))
    assert max(stood.values()) <= 2


@pytest.mark.parametrize("size", range(1, 9))
def test_each_comes_equally_often_after_each_other(size):
    rows = williams(size)
    after = Counter(pair for row in rows for pair in pairwise(row))
    assert all(sorted(row) == list(range(size)) for row in rows)
    assert len(rows) == (2 * size if size % 2 and size > 1 else size)
    assert len(after) == size * (size - 1)
    assert len(set(after.values())) <= 1


@settings(max_examples=60, deadline=None)
@given(taken=st.sets(st.integers(0, 23)), people=st.integers(0, 3))
@example(taken={*range(15), 17, 19, 22, 23}, people=3)
def test_what_is_taken_is_left_alone_and_the_same_is_given_for_the_same(taken, people):
    study = study_of(4, trials=6)
    every = list(slots_of(study))
    closed = {every[i] for i in taken}
    before = joining(study, short(), people)
    given_out = assigned(study, short(), before, closed)
    assert not closed & set(given_out)
    assert len({(slot.repetition, slot.trial) for slot in given_out}) == len(given_out)
    held = {slot for slots in before for slot in slots}
    assert bool(given_out) == (len(closed | held) < len(every))
    assert assigned(study, short(), before, closed) == given_out


def test_who_withdraws_leaves_a_hole_that_is_filled_first():
    study = study_of(4, trials=6)
    people = joining(study, short(), 3)
    stays = [people[0], people[2]]
    again = assigned(study, short(), stays, {slot for slots in stays for slot in slots})
    assert [slot.condition for slot in again] == [slot.condition for slot in people[1]]


def test_another_seed_gives_other_orders():
    first = [joining(study_of(5, trials=9, seed=seed), short(), 1)[0] for seed in range(12)]
    orders = {tuple(slot.condition for slot in slots) for slots in first}
    assert len(orders) > 6


def leaves_early(number, slots):
    return slots[:1] if number % 2 else slots


@pytest.mark.parametrize("leave", [lambda number, slots: slots[:1], leaves_early], ids=["all", "every second"])
def test_orders_stay_balanced_when_people_leave_early(leave):
    given, kept = leaving(study_of(4, trials=40), short(), 24, leave)
    assert set(Counter(tuple(slot.condition for slot in slots) for slots in given).values()) == {6}
    assert set(Counter(slots[0].condition for slots in kept).values()) == {6}


def test_a_condition_whose_boxes_always_break_leaves_the_orders_of_the_others_balanced():
    study = study_of(4, trials=40)
    given, _ = leaving(
        study, short(), 24, lambda _, slots: tuple(slot for slot in slots if slot.condition != "flip?p=0.4 + nudge")
    )
    assert set(Counter(tuple(slot.condition for slot in slots) for slots in given).values()) == {6}


@settings(max_examples=40, deadline=None)
@given(conditions=st.integers(2, 6), each=st.integers(1, 5), luck=st.randoms(use_true_random=False))
def test_what_people_leave_is_made_up_for_where_each_plays_only_some(conditions, each, luck):
    each = min(each, conditions - 1)
    study = study_of(conditions, trials=60)
    given, kept = leaving(study, short(trials_each=each), 20, lambda _, slots: slots[: luck.randint(1, each)])
    assert all(len({slot.condition for slot in slots}) == each for slots in given)
    played = Counter(dict.fromkeys(conditions_of(study), 0))
    played.update(slot.condition for slots in kept for slot in slots)
    assert max(played.values()) - min(played.values()) <= each + 1


def test_between_people_what_is_left_is_made_up_for():
    study, experiment = study_of(2, trials=60), short(design="between", trials_each=3)
    _, kept = leaving(study, experiment, 12, leaves_early)
    played = Counter(slot.condition for slots in kept for slot in slots)
    assert max(played.values()) - min(played.values()) <= 3
    whole = Counter(slots[0].condition for slots in kept if len(slots) == 3)
    assert len(whole) == 2


@pytest.mark.parametrize(("conditions", "each"), [(4, 2), (5, 2), (6, 2), (4, 3), (6, 3)])
def test_where_not_all_are_played_every_combination_is(conditions, each):
    people = joining(study_of(conditions, trials=60), short(trials_each=each), 60)
    sets = Counter(frozenset(slot.condition for slot in slots) for slots in people)
    assert len(sets) == comb(conditions, each)
