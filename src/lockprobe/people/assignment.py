"""Assignment: which boxes a new participant plays, in balanced order, and on which box they practise.

While nobody drops out and trials remain, the numbers of participants per condition differ by at most one. Orders are
rows of a Williams square: in each block of participants every condition takes each position once and follows every
other condition equally often. Among rows used equally often, the least played boxes decide. Where people play only
some conditions, or one (a design between people), the least played ones come first, which compensates for dropouts.
Nobody plays the same repetition and trial twice, because labels, layout and flips would repeat, nor a box again before
they have played all: every box takes each position and each condition about equally often. The assignment depends only
on the study's seed and on the trials given out or taken.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import product
from math import ceil

import numpy as np

from lockprobe.boxes.families import box
from lockprobe.foundation.seeds import generator, integer_seed
from lockprobe.foundation.spec import PEOPLE
from lockprobe.people.diary import Diary, Slot
from lockprobe.people.experiment import Experiment
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition
from lockprobe.trial.doses import modality_doses
from lockprobe.trial.plan import Plan

_CLOSED, _AGAIN, _PAIRED = 1e12, 1e9, 1e4
"""The costs of a trial that is taken, of a box that somebody plays again, and of one more trial of a box and a
condition, beside which one more of a box and a position costs 1."""


def conditions_of(study: Study) -> tuple[str, ...]:
    """The conditions that people play."""
    return tuple(one.label for one in study.conditions_of(PEOPLE))


def boxes_each(study: Study, experiment: Experiment) -> int:
    """How many boxes a participant plays while enough are left: at most one per repetition and trial."""
    return min(experiment.trials_each or len(conditions_of(study)), study.repetitions * study.trials)


def places_in(study: Study, experiment: Experiment) -> int:
    """How many participants the study has trials for."""
    return study.invited // boxes_each(study, experiment)


def trials_for(people: int, conditions: int, repetitions: int, experiment: Experiment) -> int:
    """Trials per condition and repetition that give this many people places.

    >>> trials_for(40, 4, 1, Experiment()), trials_for(40, 4, 1, Experiment(trials_each=1))
    (40, 10)
    """
    boxes = experiment.trials_each or conditions
    luck = max(boxes, ceil(people * boxes / conditions))  # nobody meets the same luck twice
    return ceil(luck / repetitions)


def assigned(
    study: Study, experiment: Experiment, given: Collection[Diary], on_record: Collection[tuple[str, int, int]] = ()
) -> tuple[Slot, ...]:
    """The trials of a participant who joins now, in order: :func:`boxes_each`, or fewer where not as many are left.

    ``given`` are the diaries of all others, ``on_record`` condition, repetition and number of more trials that cannot
    be given any more.
    """
    taken = {*on_record, *((slot.condition, slot.repetition, slot.trial) for one in given for slot in one.slots_kept)}
    order = _order(study, boxes_each(study, experiment), given, taken)
    return _with_luck(order, study, given, taken) if order else ()


def _order(study: Study, length: int, given: Collection[Diary], taken: set[tuple[str, int, int]]) -> list[str]:
    """Every condition equally often, as far as the length goes; the rest from those that were played least.

    Of these, ties go to the condition that others got least often together with those already found, and each takes
    the position that it has had least often.
    """
    from scipy.optimize import linear_sum_assignment

    conditions, gone = conditions_of(study), Counter(condition for condition, *_ in taken)
    left, size = {one: study.repetitions * study.trials - gone[one] for one in conditions}, len(conditions)
    orders = [tuple(slot.condition for slot in one.joined.slots) for one in given]
    played = Counter(slot.condition for one in given for slot in one.slots_kept)
    shuffled = [conditions[i] for i in generator(study.seed, "people", "orders").permutation(size)]
    rows = [[shuffled[i] for i in row] for row in williams(size)]
    used = [sum(list(order[:size]) == row for order in orders) for row in rows]
    start = min(range(len(rows)), key=lambda n: (used[n], [played[condition] for condition in rows[n]]))
    order = [condition for block in range(length // size) for condition in rows[(start + block) % len(rows)]]
    order = [condition for n, condition in enumerate(order) if order[:n].count(condition) < left[condition]]
    rests = [earlier[len(order) :] for earlier in orders]
    have, rest = Counter(order), Counter[str]()
    while len(order) + rest.total() < length and (free := [one for one in shuffled if left[one] > have[one]]):
        together = {one: sum(those.count(one) * sum(o in those for o in rest) for those in rests) for one in free}
        found = min(free, key=lambda one: (have[one], played[one], together[one]))
        rest[found] += 1
        have[found] += 1
    if not rest:
        return order
    stood = Counter(placed for earlier in rests for placed in enumerate(earlier))
    more = list(rest.elements())
    price = np.array([[stood[place, condition] for condition in more] for place in range(len(more))], dtype=float)
    return [*order, *(more[i] for i in linear_sum_assignment(price)[1].tolist())]


def _with_luck(
    order: Sequence[str], study: Study, given: Collection[Diary], taken: set[tuple[str, int, int]]
) -> tuple[Slot, ...]:
    """A different repetition and trial for each position of an order, from what is free, on different boxes.

    Those that are free in most conditions are used first, so that the last ones still fit another participant.
    """
    from scipy.optimize import linear_sum_assignment

    boxes, size = len(study.boxes), len(conditions_of(study))
    gone = Counter((repetition, trial) for _, repetition, trial in taken)
    every = product(range(1, study.repetitions + 1), range(1, study.trials + 1))
    lucks = [luck for luck in every if gone[luck] < size]
    box_of = np.array([trial % boxes for _, trial in lucks], dtype=int)
    shut = np.array([[(one, *luck) in taken for luck in lucks] for one in order]).reshape(len(order), len(lucks))
    paired = Counter((one, trial % boxes) for one, _, trial in taken)
    placed = Counter((at, slot.trial % boxes) for other in given for at, slot in enumerate(other.joined.slots))
    price = [
        [
            _AGAIN * again
            + _PAIRED * paired[one, of]
            + placed[position, of]
            + _CLOSED * bool(shut[position, box_of == of].all())
            for again in range(ceil(len(order) / boxes))
            for of in range(boxes)
        ]
        for position, one in enumerate(order)
    ]
    theirs = linear_sum_assignment(np.array(price))[1] % boxes
    ahead = np.argsort(np.argsort([gone[luck] for luck in lucks], kind="stable"), kind="stable").astype(float)
    cost = np.where(shut, _CLOSED, ahead + _AGAIN * (box_of != theirs[:, None]))
    found = zip(*(at.tolist() for at in linear_sum_assignment(cost)), strict=True)
    return tuple(
        Slot(condition=order[position], repetition=lucks[at][0], trial=lucks[at][1])
        for position, at in found
        if not shut[position, at]
    )


def williams(size: int) -> tuple[tuple[int, ...], ...]:
    """Orders of ``size`` things: each takes every position once and follows each other equally often.

    >>> williams(4)
    ((0, 1, 3, 2), (1, 2, 0, 3), (2, 3, 1, 0), (3, 0, 2, 1))

    Returns:
        ``size`` rows; twice as many where ``size`` is odd, the second half being the first in reverse.
    """
    first = [0] + [(n + 1) // 2 if n % 2 else size - n // 2 for n in range(1, size)]
    square = [tuple((place + shift) % size for place in first) for shift in range(size)]
    backwards = [row[::-1] for row in square] if size % 2 and size > 1 else []
    return (*square, *backwards)


def practice_plan(study: Study, experiment: Experiment, identity: str = "0") -> Plan:
    """The practice box of a participant, which is no trial of the study: true reports only, in a modality of the study.

    Everybody has the same box, on a panel and with labels of their own unless the panel of the study is fixed, so that
    no order in space can be learnt. No picture in it is degraded.
    """
    modality, _ = modality_doses(study.modalities_of(PEOPLE)[0])
    own = study.layout != "fixed"
    alone = replace(
        study,
        name="practice",
        agents=(PEOPLE,),
        boxes=(box(experiment.practice),),
        conditions=(Condition(modality=modality),),
        repetitions=1,
        trials=1,
        seed=integer_seed(study.seed, "people", "practice"),
        layout="shuffled" if own else "fixed",
    )
    return alone.plan(PEOPLE, alone.conditions[0], 1, 1 + int(identity, 16) if own else 1)
