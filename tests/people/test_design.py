"""A people study as it is by default: no rule of places, and nothing that practice or an earlier box teaches, opens one."""

from collections import Counter
from math import ceil

import numpy as np
import pytest
from seated import people_study, under

from lockprobe.boxes.solve import optimum
from lockprobe.people.assignment import Given, assigned, boxes_each, practice_plan, trials_for
from lockprobe.people.experiment import Experiment
from lockprobe.studies.options.studyfile import study

PERSONS = 200
FIXED = {"box": "chain-4", "layout": "fixed"}, Experiment(practice="chain-3")


def persons(asked=None, experiment=None, p=(0, 0.4), people=PERSONS):
    """The practice box and the boxes of each person, on their panels."""
    asked, experiment = asked or {}, experiment or Experiment()
    luck = trials_for(people, len(p), 1, experiment)
    planned = study("flips", agent="participant", p=list(p), repetitions=1, trials=luck, **asked)
    planned = study(
        "flips", agent="participant", p=list(p), repetitions=1, trials=ceil(luck / len(planned.boxes)), **asked
    )
    given = []
    for person in range(people):
        slots = assigned(planned, experiment, given)
        given.append(Given(slots, slots))
        identity = f"{person:08x}"
        yield practice_plan(planned, experiment, identity).box, [slot.plan(planned, identity).box for slot in slots]


class Learner:
    """Opens a box by trying orders, and begins the next one in the order of the places at which the last one opened."""

    def __init__(self):
        self.places = (0.5,)

    def steps(self, box):
        """Those that it takes until the box opens; then it knows in which order."""
        left, order = [joint for joint in range(len(box.joints)) if joint != box.target_index], []
        for place in np.interp(np.linspace(0, 1, len(left)), np.linspace(0, 1, len(self.places)), self.places):
            order.append(min(left, key=lambda joint: abs(box.joints[joint].place[0] - place)))
            left.remove(order[-1])
        here, steps, opened = box.initial, 0, []
        while True:
            for joint in [*order, box.target_index]:
                steps += 1
                if here[joint] == box.initial[joint]:
                    here, moved = box.attempt(here, joint)
                    opened += [joint] * moved
            if box.target_index in opened:
                self.places = tuple(box.joints[joint].place[0] for joint in opened[:-1]) or (0.5,)
                return steps


def learnt(found):
    """Steps of a learner in each of the boxes of each person, after practice."""
    rows = []
    for practice, boxes in found:
        learner = Learner()
        learner.steps(practice)
        rows.append([learner.steps(box) for box in boxes])
    return np.array(rows)


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


def test_practice_and_earlier_boxes_teach_no_order_in_space():
    now, before = learnt(persons()), learnt(persons(*FIXED))
    assert set(before.ravel()) == {4}
    assert np.mean(now == 4) < 0.25  # one order of six
    first, second = now.mean(axis=0)
    assert abs(first - second) < 3 * np.std(now[:, 1] - now[:, 0]) / np.sqrt(PERSONS)


@pytest.mark.parametrize(
    ("people", "p", "how"),
    [(40, (0, 0.2, 0.4, 0.6), {}), (37, (0, 0.2, 0.4), {}), (40, (0, 0.4), {"trials_each": 8}),
     (60, (0, 0.4), {"trials_each": 1})],
)  # fmt: skip
def test_nobody_plays_a_box_twice_and_boxes_are_balanced_over_conditions_and_positions(people, p, how):
    experiment = Experiment(**how)
    trials = ceil(trials_for(people, len(p), 1, experiment) / 8)
    planned = study("flips", agent="participant", p=list(p), repetitions=1, trials=trials)
    given, conditions, positions = [], Counter(), Counter()
    for _ in range(people):
        slots = assigned(planned, experiment, given)
        given.append(Given(slots, slots))
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
    planned = study("flips", agent="participant")
    plans = [practice_plan(planned, Experiment(), f"{person:08x}") for person in range(60)]
    assert {plan.box.name for plan in plans} == {"common-cause-3"}
    places = Counter(plan.box.joints[plan.box.target_index].place for plan in plans)
    assert len(places) == 4
    assert max(places.values()) < 30
    assert plans[0] == practice_plan(planned, Experiment(), f"{0:08x}")
