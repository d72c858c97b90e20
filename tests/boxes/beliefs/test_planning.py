"""Plans are the best there are: against dynamic programming without shortcuts, and the exact figures of the notes."""

from dataclasses import replace

import numpy as np
import pytest
from boxes.beliefs.enumeration import histories

from lockprobe.boxes.beliefs.exact import MOST_PLANNED, Planner, can_plan, planner
from lockprobe.boxes.beliefs.planning import best_joints, expected_steps, information
from lockprobe.boxes.beliefs.posterior import begin, entropy, noise_model, update
from lockprobe.boxes.beliefs.structures import interlocks
from lockprobe.foundation.errors import BadValue

NAIVE = noise_model("naive")


def slow_values(known):
    """V of every set and configuration that can be met from the prior anywhere, by sweeps over all of them."""
    start = [
        (frozenset(np.flatnonzero(known.distance[:, c] < 255).tolist()), c) for c in range(0, 1 << known.joints, 2)
    ]
    ways, queue = {}, start
    while queue:
        alive, here = state = queue.pop()
        if state in ways:
            continue
        ways[state] = []
        for joint in range(known.joints):
            moved = frozenset(s for s in alive if known.masks[here][joint] >> s & 1)
            parts = [(moved, here ^ 1 << joint if joint else None), (alive - moved, here)]
            ways[state].append([(len(part) / len(alive), part, there) for part, there in parts if part])
            queue += [(part, there) for part, there in parts if part and there is not None]
    values = dict.fromkeys(ways, 0.0)
    for _ in range(100):
        values = {
            state: min(
                1 + sum(f * (values[part, there] if there is not None else 0.0) for f, part, there in way)
                for way in found
            )
            for state, found in ways.items()
        }
    return values


@pytest.mark.parametrize(("prior", "joints"), [("chains", 3), ("single-parent", 3), ("chains", 4)])
def test_planning_is_dynamic_programming(prior, joints):
    known = interlocks(prior, joints)
    fresh, slow = Planner(known), slow_values(known)
    assert len(slow) >= 12
    for (alive, here), value in slow.items():
        number = sum(1 << s for s in alive)
        assert fresh.value(number, here) == pytest.approx(value)
        assert min(fresh.values(number, here)) == pytest.approx(value)


@pytest.mark.parametrize(
    ("name", "kinds", "states_only"),
    [
        ("0.3", ["memoryless"], False),
        ("0.3", ["latched"], False),
        ("0.3", ["outcome-only"], False),
        ("aware", ["memoryless", "latched"], False),
        ("0.3", ["latched"], True),
        ("0.3", ["re-observed"], False),
        ("0.3", ["integrated"], True),
        ("aware", ["re-observed", "integrated"], True),
    ],
)
def test_information_is_what_reports_give_on_average(name, kinds, states_only):
    """Over every next report, told or that the box opens, weighed by slow enumeration."""
    known = interlocks("single-parent", 3)
    unsaid = "outcomes" if "re-observed" in kinds else "positions"
    noise = noise_model(name, kinds[0] if kinds[0] != "outcome-only" and len(kinds) == 1 else unsaid)
    for joints in [(1, 2), (1, 1), (0, 2)]:
        longer = [histories(known.needs, kinds, (*joints, joint), noise.p, states_only) for joint in range(3)]
        for reports, behind in histories(known.needs, kinds, joints, noise.p, states_only).items():
            belief = begin(known, noise)
            for report in reports:
                belief = update(belief, report)
            total, expected = sum(behind.values()), []
            for joint in range(3):
                left = 0.0
                for more, mass in longer[joint].items():
                    if more[:-1] == reports:
                        left += sum(mass.values()) / total * entropy(update(belief, more[-1]))
                opening = belief.weights * known.may_move(belief.configuration)[:, 0]
                if joint == 0 and (opens := opening.sum()) > 0:
                    left += opens * entropy(replace(belief, weights=opening / opens))
                expected.append(entropy(belief) - left)
            assert information(belief) == pytest.approx(expected, abs=1e-9)


def test_what_cannot_be_planned_is_refused_with_what_can():
    known = interlocks("chains", 7)
    assert not can_plan(known)
    with pytest.raises(
        BadValue,
        match=f"got '720 interlocks of prior chains over 7 joints', expected at most {MOST_PLANNED} .*plan=information",
    ):
        expected_steps(begin(known, NAIVE))
    assert best_joints(begin(known, NAIVE), "information").any()
    assert planner(interlocks("chains", 6)) is planner(interlocks("chains", 6))
