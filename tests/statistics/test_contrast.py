"""Contrasts of conditions: their value, their exact test, what breaks trials, and the families that they belong to."""

from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest
from builders import make_trial
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.statistics.blocks import block_mean, contrast
from lockprobe.statistics.contrast import declared, effects, interactions
from lockprobe.statistics.course import cells_of
from lockprobe.statistics.outcomes import BlockOrder, outcomes
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.single import run_trial
from lockprobe.studies.study import design_of
from lockprobe.trial.condition import Contrast

CROSSING = [1, 1, -1, -1]
TEMPLATE = outcomes([make_trial([0] * 20, trial=i, budget=20) for i in range(1, 61)])


def group(solved):
    """One ended trial for each entry."""
    return replace(
        TEMPLATE.at(np.arange(60) < len(solved)), broke=TEMPLATE.broke[:0], solved=np.asarray(solved, dtype=bool)
    )


def drawn(seed, chances, n=40):
    rng = np.random.default_rng(seed)
    return [group(rng.random(n) < chance) for chance in chances]


def found_of(groups):
    """The first half of the groups less the second; of four groups a difference of differences."""
    names, half = list("abcd")[: len(groups)], len(groups) // 2
    return contrast(dict(zip(names, groups, strict=True)), Contrast(of=names[:half], minus=names[half:]), scale=half)


@given(st.lists(st.tuples(*[st.booleans()] * 4), min_size=2, max_size=9))
def test_the_p_value_of_an_interaction_is_that_of_every_flip_of_the_signs_of_its_blocks(blocks):
    solved = np.array(blocks)
    found = found_of([group(column) for column in solved.T])
    sums = solved.astype(int) @ CROSSING
    flipped = [abs(np.dot(signs, sums)) for signs in product((-1, 1), repeat=len(sums))]
    assert found.value == pytest.approx(sums.mean())
    assert found.p_value == pytest.approx(np.mean([one >= abs(sums.sum()) for one in flipped]))


def test_of_several_boxes_a_contrast_holds_of_boxes_like_these():
    """Of six boxes two alone change success: from 40 blocks that is clear, from six boxes it is not."""
    box = np.array([f"box-{i % 6}" for i in range(40)])
    never, twice = group([False] * 40), group([i % 6 < 2 for i in range(40)])
    alone, over = (found_of([replace(one, box=of) for one in (twice, never)]) for of in (box[:0], box))
    assert alone.clear
    assert not over.clear
    assert (over.value, over.p_value > alone.p_value) == (alone.value, True)


def test_broken_trials_count_for_it_at_one_end_and_against_it_at_the_other():
    """Five trials of each group broke: as the groups with these solved or not, by the sign of their weight."""
    whole, broke = drawn(6, [0.5] * 4), np.arange(40) < 5
    ends = [
        found_of(
            [
                replace(one, solved=np.where(broke, (w > 0) == high, one.solved))
                for one, w in zip(whole, CROSSING, strict=True)
            ]
        )
        for high in (False, True)
    ]
    made = found_of([replace(one, broke=broke) for one in whole])
    assert (made.low, made.high) == (min(one.low for one in ends), max(one.high for one in ends))
    assert made.p_value == 1.0


def cell(trials):
    (found,) = cells_of(trials).values()
    return found


AGENT, CAREFUL, BASELINE, BLIND = "cognitive:perseverant", "cognitive:careful", "human-inspired", "random"


def played(conditions, agents=(AGENT,), n=6):
    """The cells and the design of a study of these conditions beside the truth."""
    planned = study("flips", agent=list(agents), p=[0], condition=list(conditions), trials=n, repetitions=1)
    return {
        (agent, one.label): cell([run_trial(agent=agent, condition=one.label, trial=i + 1, seed=3) for i in range(n)])
        for agent in agents
        for one in planned.conditions
    }, design_of(planned)


def named(found):
    """The effects on single conditions."""
    return [(one.agent, one.control, one.condition, one.corrected_for) for one in found if not one.factor]


def test_agents_that_a_study_is_about_are_one_family_and_baselines_another_and_who_plays_alike_counts_in_none():
    agents = (AGENT, CAREFUL, BASELINE, BLIND)
    assert named(effects(*played(["drop?p=0.5"], agents))) == [
        (agent, "truth", "drop?p=0.5", many) for agent, many in zip(agents, (2, 2, 1, 1), strict=True)
    ]


def test_a_condition_that_changed_nothing_or_shares_no_trial_with_the_control_is_compared_with_nothing():
    cells, design = played(["history?last=50", "tremble?p=0.5", "tremble?p=0.5 + nudge"])
    cells[AGENT, "tremble?p=0.5 + nudge"] = cell([make_trial([0], trial=1, broken="model")])
    assert named(effects(cells, design)) == [(AGENT, "truth", "tremble?p=0.5", 1)]
    del cells[AGENT, "truth"]
    assert named(effects(cells, design)) == []
    cells, design = played(["tremble?p=0.5", "drop?p=0.5"], (AGENT, CAREFUL))
    control = {(CAREFUL, "truth"): cells.pop((CAREFUL, "truth"))}
    alone = {at: one for at, one in cells.items() if at[0] == AGENT} | control
    for those in (cells, alone):
        assert {(agent, many) for agent, *_, many in named(effects(those, design))} == {(AGENT, 2)}


def idle_in(cells, label, *specs):
    """The cells as if these interventions had changed nothing there."""
    trials = [
        replace(
            one, changed=dict(one.changed) | dict.fromkeys(specs, 0), changed_steps=one.changed_steps * (len(specs) < 2)
        )
        for one in cells[AGENT, label].trials
    ]
    return cells | {(AGENT, label): cell(trials)}


def test_what_changed_nothing_beside_others_is_in_no_interaction_and_a_control_may_change_nothing():
    flip, tremble = "flip?p=0.4", "tremble?p=0.3"
    cells, design = played([flip, tremble, f"{flip} + {tremble}"])
    assert len(list(interactions(cells, design))) == 1
    control = cells[AGENT, "truth"]
    watched = replace(control, order=BlockOrder(plans=((1, 6),)))
    assert list(interactions(cells | {(AGENT, "truth"): watched}, design)) == []  # none holds at every look
    assert list(interactions({at: one for at, one in cells.items() if one is not control}, design)) == []
    idle = idle_in(cells, f"{flip} + {tremble}", tremble)
    assert list(interactions(idle, design)) == []
    assert [one.condition for one in effects(idle, design)][-1] == f"{flip} + {tremble}"  # its flips acted
    cells, design = played(["warn", tremble])
    design = replace(design, arms=tuple(arm for arm in design.arms if arm.label != "truth"))
    assert named(effects(idle_in(cells, "warn", "warn", ""), design)) == [(AGENT, "warn", tremble, 1)]


def test_a_study_declares_contrasts_of_agents_and_not_of_people():
    cells, design = played(["tremble?p=0.3"], n=8)
    asked = {"tremor": Contrast(of=("tremble?p=0.3",), minus=("truth",))}
    ((*who, (change, of, minus)),) = declared(cells, asked, design)
    assert who == [AGENT, "tremor", 1]
    assert change.value == pytest.approx(of.value - minus.value)
    assert of.low < of.value < of.high
    seated = {
        (agent, label): cell([replace(one, agent=f"participant:{i:04d}") for i, one in enumerate(own.trials)])
        for (agent, label), own in cells.items()
    }
    assert list(declared(seated, asked, design)) == []


def test_a_contrast_of_misreading_is_of_blocks_with_statements_under_all_of_its_conditions():
    """Of two statements about blocked joints one is false where it says moved; the last block has none of them."""
    design = design_of(study("flips", agent=[AGENT], p=[0, 0.4], trials=9, repetitions=1))

    def said(p, wrong):
        claims = [[None, *["moved"] * n, *["blocked"] * (2 - n)] for n in wrong]
        return [make_trial([0] * 3, agent=AGENT, p=p, trial=i, claims=one) for i, one in enumerate(claims, 1)]

    lies, truth = said(0.4, [2, 1, 2, 1, 2, 2, 1, 2]), said(0.0, [0, 1, 0, 0, 1, 0, 0, 0])
    silent = make_trial([0] * 3, agent=AGENT, p=0.4, trial=9)
    cells = {(AGENT, "flip?p=0.4"): cell([*lies, silent]), (AGENT, "truth"): cell([*truth, *said(0.0, [0] * 9)[8:]])}
    of = Contrast(of=("flip?p=0.4",), minus=("truth",), measure="misreading")
    found = list(declared(cells, {"lies": of, "again": of}, design))
    changes = np.array([1, 0, 1, 0.5, 0.5, 1, 0.5, 1])
    expected = block_mean(changes[:, None], choices=2)
    assert [(name, many, len(own)) for _, name, many, own in found] == [("lies", 2, 1), ("again", 2, 1)]
    change = found[0][-1][0]
    assert (change.value, change.n, change.low, change.high) == (
        pytest.approx(changes.mean()), 8, expected.low, expected.high
    )  # fmt: skip
    assert change.p_value == pytest.approx(2 * expected.p_value)
    assert list(declared(cells | {(AGENT, "flip?p=0.4"): cell([silent])}, {"lies": of}, design)) == []


def test_interactions_are_corrected_for_their_number_and_stand_once_in_a_grid_where_there_is_one():
    parts = ["nudge", "tremble?p=0.4", "drop?p=0.4"]
    conditions = [" + ".join(own) for size in (1, 2) for own in combinations(parts, size)]
    found = list(interactions(*played(conditions)))
    assert [choices for *_, choices in found] == [3] * 3  # two crossings with a nudge, and a grid
    assert [one.conditions[1, 1] for _, one, *_ in found if not one.axes] == conditions[3:5]
    assert [axis.name for axis in found[-1][1].axes] == ["tremble p", "drop p"]
    whole = list(interactions(*played(["flip?p=0.4", "tremble?p=0.1", "flip?p=0.4 + tremble?p=0.1"])))
    ((_, one, _, choices),) = whole
    of, minus = ("truth", "flip?p=0.4 + tremble?p=0.1"), ("tremble?p=0.1", "flip?p=0.4")
    assert (one.interaction, choices) == (Contrast(of=of, minus=minus), 1)


def test_other_conditions_change_no_p_value_of_a_factor_and_every_group_is_corrected_for_all_of_it():
    sticky = [f"flip?p={p}{option}" for p in (0.2, 0.4) for option in ("", "&others=kept")]
    cells, design = played(sticky)
    found = [one for one in effects(cells, design) if one.factor]
    assert [(one.control, one.condition, one.corrected_for) for one in found] == [
        ("flip?p=0.2", "flip?p=0.2&others=kept", 2), ("flip?p=0.4", "flip?p=0.4&others=kept", 2),
    ]  # fmt: skip
    more, beside = played(["nudge", *sticky])
    assert [one for one in effects(more, beside) if one.factor] == found
