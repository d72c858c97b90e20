"""Modalities of one agent are compared from low to high fidelity, with trials that share their luck kept together."""

import numpy as np
import pytest
from builders import SOLUTION, make_trial

from lockprobe.statistics.conditions.modalities import by_fidelity, modality_effect, spoken
from lockprobe.statistics.summary import summarise


def trials_of(modality, waits, agent="viewer"):
    """Trials that solve the box after so many wasted steps, or never."""
    return [
        make_trial([0] * (20 if wait is None else wait) + list(SOLUTION) * (wait is not None), agent=agent,
                   modality=modality, study="modalities", trial=i)
        for i, wait in enumerate(waits, 1)
    ]  # fmt: skip


SOON, LATE = [i % 4 for i in range(10)], [8 + i % 4 for i in range(10)]
MIDDLE = [4 + i % 4 for i in range(10)]


def test_the_papers_order_is_found_where_it_is():
    effect = modality_effect([trials_of("symbolic", LATE), trials_of("rgb", SOON), trials_of("rgbd", MIDDLE)])
    assert effect.modalities == ("rgb", "rgbd", "symbolic")
    assert (effect.direction, effect.detectable) == (-1, True)
    assert [(pair.first, pair.second) for pair in effect.pairs] == [
        ("rgb", "rgbd"), ("rgb", "symbolic"), ("rgbd", "symbolic"),
    ]  # fmt: skip
    assert all(pair.hazard_ratio < 1 and pair.final.value == 0 for pair in effect.pairs)
    assert all(pair.p_value < pair.p_adjusted <= 1 for pair in effect.pairs[:2])


def test_variants_of_a_modality_are_of_equal_fidelity():
    """They may well differ, which all together and pairs say; but there is no higher and lower."""
    effect = modality_effect([trials_of("rgbd?depth=gray", SOON), trials_of("rgbd?depth=height", LATE)])
    assert (effect.direction, effect.p_value, effect.detectable) == (0, None, False)
    assert effect.p_all < 0.05
    assert effect.pairs[0].p_adjusted < 0.05


def test_the_trend_scores_fidelity_and_not_places_in_a_list():
    """Two variants of RGB-D, one soon and one late: at equal fidelity it does not matter which is named first."""
    trials = {"rgb": MIDDLE, "symbolic": LATE}
    found = [
        modality_effect([
            *(trials_of(modality, waits) for modality, waits in trials.items()),
            trials_of("rgbd?depth=gray", gray), trials_of("rgbd?depth=height", height),
        ])
        for gray, height in ((SOON, LATE), (LATE, SOON))
    ]  # fmt: skip
    assert found[0].p_value == pytest.approx(found[1].p_value)
    assert found[0].direction == found[1].direction == -1


def test_a_modality_without_a_rank_stays_out_of_the_trend():
    ranked = [trials_of("rgb", SOON), trials_of("symbolic", LATE)]
    alone, beside = modality_effect(ranked), modality_effect([*ranked, trials_of("smell", MIDDLE)])
    assert (beside.direction, beside.p_value) == (alone.direction, alone.p_value)
    assert beside.modalities == ("rgb", "symbolic", "smell")
    assert len(beside.pairs) == 3
    assert modality_effect([ranked[0], trials_of("smell", MIDDLE)]).p_value is None


def test_who_solves_it_at_all_is_compared_in_pairs():
    effect = modality_effect([trials_of("rgb", [*SOON[:6], *[None] * 4]), trials_of("symbolic", [None, *SOON[1:]])])
    (pair,) = effect.pairs
    assert (pair.final.only_first, pair.final.only_second, pair.final.n) == (1, 4, 10)
    assert pair.final.p_value == pytest.approx(0.375)


def test_too_few_trials_are_not_tested_and_one_modality_not_compared():
    effect = modality_effect([trials_of("rgb", SOON[:3]), trials_of("symbolic", LATE[:3])])
    assert (effect.p_value, effect.p_all) == (None, None)
    assert not effect.detectable
    assert modality_effect([trials_of("rgb", SOON)]) is None
    broken = [make_trial([0], agent="viewer", modality="rgb", broken="plant")]
    assert modality_effect([broken, trials_of("symbolic", SOON)]) is None


def test_where_nothing_is_a_trend_is_seldom_found():
    """The docstring has figures of more studies; here fewer, at half the luck shared."""
    rng, found = np.random.default_rng(7), []
    for _ in range(40):
        shared = rng.geometric(0.12, 10)
        waits = [np.where(rng.random(10) < 0.5, shared, rng.geometric(0.12, 10)) for _ in range(3)]
        groups = [
            trials_of(modality, [int(w) if w <= 16 else None for w in wait])
            for modality, wait in zip(("rgb", "rgbd", "symbolic"), waits, strict=True)
        ]
        found.append(modality_effect(groups).detectable)
    assert sum(found) <= 5  # 2.2 standard errors above 5 %, if it rejected that often


def test_modalities_are_named_and_ordered_as_in_the_paper():
    shown = ["symbolic", "rgbd?depth=gray&near=0.5", "symbolic?source=verdict", "rgb"]
    assert [spoken(one) for one in sorted(shown, key=by_fidelity)] == [
        "RGB", "RGB-D, depth=gray, near=0.5", "positions and outcomes in words", "verdicts of the arm",
    ]  # fmt: skip


def test_a_summary_keeps_modalities_apart_and_names_them():
    trials = [trial for modality in ("rgb", "symbolic") for trial in trials_of(modality, SOON)]
    trials += trials_of("symbolic", LATE, agent="human-inspired")
    summary = summarise(trials)
    assert [agent.name for agent in summary.agents] == [
        "viewer (RGB)",
        "viewer (positions and outcomes in words)",
        "human-inspired",
    ]
    assert [effect.agent for effect in summary.modalities] == ["viewer"]
    assert len(summary.paces) == 3
    alone = summarise(trials_of("rgb", SOON))
    assert alone.agents[0].name == "viewer (RGB)"
    assert alone.modalities == ()
    assert summarise(trials_of("symbolic", SOON)).agents[0].name == "viewer"


def test_several_agents_are_one_family_and_baselines_another():
    def found(*agents):
        played = [trials_of(*one, agent=agent) for agent in agents for one in (("rgb", SOON), ("symbolic", MIDDLE))]
        return {one.agent: one for one in summarise([trial for members in played for trial in members]).modalities}

    alone, three = found("viewer"), found("viewer", "observer", "random")
    assert {agent: one.agents for agent, one in three.items()} == {"viewer": 2, "observer": 2, "random": 1}
    for one, two in [
        (alone["viewer"].p_value, three["viewer"].p_value),
        (alone["viewer"].p_all, three["viewer"].p_all),
    ]:
        assert two == pytest.approx(min(1.0, 2 * one))
    assert three["viewer"].pairs[0].p_adjusted == pytest.approx(min(1.0, 2 * alone["viewer"].pairs[0].p_adjusted))
    assert three["random"].p_value == alone["viewer"].p_value
