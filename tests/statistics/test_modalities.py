"""Modalities of one agent are compared from low to high fidelity, with trials that share their luck kept together."""

import pytest
from builders import SOLUTION, make_trial

from lockprobe.statistics.course import cells_of, courses
from lockprobe.statistics.how_soon import modality_effects
from lockprobe.statistics.modalities import by_fidelity, spoken


def trials_of(modality, waits, agent="viewer"):
    """Trials that solve the box after so many wasted steps, or never."""
    return [
        make_trial([0] * (20 if wait is None else wait) + list(SOLUTION) * (wait is not None), agent=agent,
                   modality=modality, study="modalities", trial=i)
        for i, wait in enumerate(waits, 1)
    ]  # fmt: skip


def effects(*groups):
    return {
        one.agent: one
        for one in modality_effects(courses(cells_of([trial for group in groups for trial in group]).values()))
    }


def effect_of(**waits):
    """The effect on an agent that solves the box after these waits, by modality."""
    return effects(*(trials_of(modality, own) for modality, own in waits.items())).get("viewer")


SOON, MIDDLE, LATE = ([wait + i % 4 for i in range(10)] for wait in (0, 4, 8))


def test_the_papers_order_is_found_where_it_is():
    effect = effect_of(symbolic=LATE, rgb=SOON, rgbd=MIDDLE)
    assert effect.modalities == ("rgb", "rgbd", "symbolic")
    assert (effect.trend.direction, effect.trend.p_value < 0.05) == (-1, True)
    pairs = [("rgb", "rgbd"), ("rgb", "symbolic"), ("rgbd", "symbolic")]
    assert [both for *both, _, _, _ in effect.pairs] == [[*both] for both in pairs]
    assert all(hazard.value < 1 and gap.value == 0 and gap.first.n == 10 for *_, hazard, gap, _ in effect.pairs)
    assert all(steps.value > 0 for *_, steps in effect.pairs)
    alone = effect_of(symbolic=LATE, rgb=SOON).pairs[0][2].p_value
    assert alone < effect.pairs[1][2].p_value <= 3 * alone


def test_a_trend_that_broken_trials_may_have_made_is_none():
    """Half of the trials of the lowest fidelity broke in the second step, and may have been solved then, or never."""
    how = {"agent": "viewer", "modality": "rgb", "study": "modalities", "broken": "plant"}
    broken = [make_trial([0], trial=i, **how) for i in range(1, 11, 2)]
    whole, bounded = (
        effects(broken * broke + trials_of("rgb", MIDDLE)[broke :: 1 + broke], trials_of("symbolic", LATE))["viewer"]
        for broke in (False, True)
    )
    assert whole.trend.p_value < 0.05
    assert (bounded.trend.direction, bounded.trend.p_value, bounded.pairs[0][2].p_value) == (-1, 1.0, 1.0)


def test_modalities_are_named_and_ordered_as_in_the_paper():
    shown = ["symbolic", "rgbd?depth=gray&near=0.5", "symbolic?source=verdict", "rgb"]
    assert [spoken(one) for one in sorted(shown, key=by_fidelity)] == [
        "RGB", "RGB-D, depth=gray, near=0.5", "positions and outcomes in words", "verdicts of the arm",
    ]  # fmt: skip


def test_several_agents_are_one_family_and_baselines_another():
    def found(*agents):
        shown = (("rgb", SOON), ("symbolic", MIDDLE))
        return effects(*(trials_of(*one, agent=agent) for agent in agents for one in shown))

    (alone,), three = found("viewer").values(), found("viewer", "observer", "random")
    assert {agent: one.agents for agent, one in three.items()} == {"viewer": 2, "observer": 2, "random": 1}
    assert three["viewer"].trend.p_value == pytest.approx(min(1.0, 2 * alone.trend.p_value))
    assert three["viewer"].pairs[0][2].p_value == pytest.approx(min(1.0, 2 * alone.pairs[0][2].p_value))
    assert three["random"].trend.p_value == alone.trend.p_value
