"""Where joints may sit, and that moving them changes nothing else."""

import itertools
from collections import Counter

import numpy as np
import pytest

from lockprobe.boxes.families import box
from lockprobe.boxes.layouts import laid_out, locking_pairs, neutral_order, places, redealt
from lockprobe.boxes.solve import difficulty, random_curve

LAYOUTS = ("serial", "zigzag", "ngram", "grid", "scattered", "misleading")
NAMES = ("chain-6", "bichain-4", "reset", "common-cause-4", "branched", "random-7-2")


def rng(seed=1):
    return np.random.default_rng(seed)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("count", range(2, 9))
def test_joints_lie_on_the_panel_and_apart(layout, count):
    for seed in range(20):
        spots = places(layout, count, rng(seed))
        assert len(spots) == count
        assert all(0 <= x <= 1 and 0 <= y <= 1 for x, y in spots)
        assert min(np.hypot(a[0] - b[0], a[1] - b[1]) for a, b in itertools.combinations(spots, 2)) > 0.1


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_another_panel_is_the_same_puzzle(name, layout):
    old, new = box(name), laid_out(box(name), layout, rng(), dealt=True)
    assert random_curve(new)[-1] == pytest.approx(random_curve(old)[-1], rel=1e-9)
    assert random_curve(new, repeats=False)[-1] == pytest.approx(random_curve(old, repeats=False)[-1], rel=1e-9)
    assert difficulty(new).optimal_plans == difficulty(old).optimal_plans
    named, again = laid_out(old, layout, rng()), redealt(old, rng())
    assert (named.interlock, set(named.names)) == (old.interlock, set(old.names)) == (again.interlock, set(again.names))
    assert [joint.place for joint in again.joints] == [joint.place for joint in old.joints]


@pytest.mark.parametrize("name", ["chain-4", "fork"])
def test_a_neutral_order_neither_follows_nor_avoids_the_interlock_and_puts_every_joint_anywhere(name):
    locking, row = locking_pairs(box(name)), [(0, 1), (1, 2), (2, 3)]
    luck = rng()
    drawn = Counter(tuple(neutral_order(locking, row, 4, luck)) for _ in range(4000))
    orders = [*itertools.permutations(range(4))]
    met = [sum(tuple(sorted(order[i : i + 2])) in locking for i in range(3)) for order in orders]
    kept = [order for order, count in zip(orders, met, strict=True) if abs(count - np.mean(met)) < 1]
    assert {*drawn} == {*kept}
    assert all(0.7 < count * len(kept) / 4000 < 1.3 for count in drawn.values())
    assert {Counter(at)[joint] for at in zip(*kept, strict=True) for joint in range(4)} == {len(kept) // 4}


@pytest.mark.parametrize("name", ["chain-4", "chain-8", "bichain-5", "branched"])
def test_misleading_puts_joints_that_lock_each_other_apart(name):
    """No order of the same places puts them further apart."""
    laid = laid_out(box(name), "misleading", rng())
    here = np.array([joint.place for joint in laid.joints])
    far, pairs = np.hypot(*(here[:, None] - here[None]).transpose(2, 0, 1)), locking_pairs(laid)
    apart = sum(far[pair] for pair in pairs)
    for seed in range(100):
        order = rng(seed).permutation(len(laid.joints))
        assert sum(far[order[a], order[b]] for a, b in pairs) <= apart + 1e-6
