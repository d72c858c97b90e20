"""The course of a study that stops when it is decided: the rule over outcomes, and the runner over records."""

from dataclasses import replace

import numpy as np
import pytest

from lockprobe.studies.decisions import LOOK_EVERY, Family, Question, answers, decisions, families, wanted
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.runner import run_study
from lockprobe.studies.running.single import run_trial
from lockprobe.studies.study import Until
from lockprobe.trial.record import TrialError

DECIDED, WIDTH = Until(rule="decided"), Until(rule="width", points=0.4)


def outcomes(success, blocks, seed, broken=0.0):
    rng = np.random.default_rng(seed)
    solved = rng.random((len(success), blocks)) < np.array(success)[:, None]
    broke = rng.random(solved.shape) < broken
    values = np.where(broke, np.nan, solved)
    return {label: (values[i], broke[i]) for i, label in enumerate("tabcd"[: len(success)])}


def look_by_look(asked, whole, until):
    """The course as the runner takes it: five blocks at a time, with no knowledge of what follows."""
    size = len(next(iter(whole.values()))[0])
    seen = {label: (np.full(size, np.nan), np.zeros(size, dtype=bool)) for label in whole}
    bought = dict.fromkeys(whole, 0)
    for start in range(0, size, LOOK_EVERY):
        known = {label: (solved[:start], broke[:start]) for label, (solved, broke) in seen.items()}
        if not (kept := wanted(decisions(asked, known, until), start)):
            break
        for label in kept:
            part = slice(start, start + LOOK_EVERY)
            for mine, all_of_it in zip(seen[label], whole[label], strict=True):
                mine[part] = all_of_it[part]
            bought[label] = min(size, start + LOOK_EVERY)
    return decisions(asked, seen, until), bought


ONE_FAMILY = [Family(tuple(Question(one, ((one, "t"),)) for one in "abc"), 1)]
TOTAL = Question("total", (("a", "t"),))
PARTS = [
    Family((TOTAL,), 1),
    Family((Question("first", (("b", "t"), ("c", "a"))),), 5 / 3, after=TOTAL),
    Family((Question("second", (("c", "t"),)),), 5 / 3, after=TOTAL),
]


WHY = study("why", agent="human-inspired")


@pytest.mark.parametrize(
    ("asked", "success", "until", "broken", "blocks"),
    [
        (ONE_FAMILY, (0.2, 0.99, 0.5, 0.2), DECIDED, 0.0, 32),
        (ONE_FAMILY, (0.99, 0.99, 0.9, 0.1), DECIDED, 0.03, 32),
        (PARTS, (0.1, 0.95, 0.05, 0.2), DECIDED, 0.0, 52),
        (ONE_FAMILY, (0.01, 0.99, 0.5, 0.01), WIDTH, 0.0, 42),
    ],
)
def test_what_is_decided_stays_whatever_the_later_blocks_hold(asked, success, until, broken, blocks):
    """Conditions are dropped at different looks; what would have been played of them changes nothing."""
    whole = outcomes(success, blocks, 0, broken)
    found, bought = look_by_look(asked, whole, until)
    assert len({*bought.values()}) > 1
    assert {one.verdict for one in found} <= ({None, "narrow"} if until == WIDTH else {None, "effect", "small"})
    for label, end in bought.items():
        whole[label][0][end:] = 0
    assert look_by_look(asked, whole, until) == (found, bought)


def test_the_runner_decides_and_buys_what_follows_from_the_rule(tmp_path):
    most, varied = 25, {"p": [0, 0.6], "condition": ["nudge"]}
    planned = study("flips", agent="cognitive:perseverant", until="decided", trials=most, seed=3, **varied)
    (agent,) = planned.agents
    whole = {}
    for one in planned.conditions:
        played = [
            run_trial(agent=agent, condition=one, trial=i, seed=3, layout=planned.layout, shuffle=planned.shuffle)
            for i in range(1, most + 1)
        ]
        whole[one.label] = np.array([float(trial.solved) for trial in played]), np.zeros(most, dtype=bool)
    found, bought = look_by_look(families(planned, agent), whole, planned.until)
    trials = run_study(planned, tmp_path / "run")
    others = [replace(one, agent="random", ending="budget") for one in trials]
    again = [
        replace(one, ending="error", error=TrialError(boundary="model", message="it broke", step=1))
        for one in trials[:3]
    ]
    assert bought == {one.label: sum(t.condition == one.label for t in trials) for one in planned.conditions}
    real = answers(planned, agent, [*trials, *others, *again])
    assert [(one.question, one.verdict, one.at) for one in found] == [
        (one.question, one.verdict, one.at) for one in real
    ]
    assert len({*bought.values()}) > 1


LAST = ("false last after true", "false last after false")


@pytest.mark.parametrize(
    ("solved", "needed"),  # truth, lie, truth-truth, lie-truth, truth-lie, lie-lie, remark
    [
        ("0100110", LAST),
        ("1011001", LAST),  # lies hurt
        ("0101010", ("false first before true", "false first before false")),
        ("0100010", ("both false", "false last after false", "false first before false", "interaction")),
        ("0101110", ("false first before true", "false last after true", "interaction")),
        ("0111111", ("true correction", "remark")),
    ],
)
@pytest.mark.parametrize("alike", [0, 2])
def test_a_study_of_controls_stops_when_a_mechanism_is_named(solved, needed, alike):
    """Contrasts that it does not need stay open, and no arm is played for them. A few blocks in front are alike."""
    names = [one.label for one in WHY.conditions]
    arms = {arm: (np.repeat([0.0, float(of)], [alike, 32]), np.zeros(alike + 32, dtype=bool))
            for arm, of in zip(names, solved, strict=True)}  # fmt: skip
    course, bought = look_by_look(families(WHY, "human-inspired"), arms, DECIDED)
    found = {one.question.name: (one.verdict, one.at) for one in course}
    last = max(found[name][1] for name in ("total", *needed))
    assert [found[name][0] for name in ("total", *needed)] == ["effect"] * (1 + len(needed))
    assert max(at for _, at in found.values()) == last
    assert {verdict for verdict, _ in found.values()} == {"effect", "not needed"}
    assert max(bought.values()) == -(-last // LOOK_EVERY) * LOOK_EVERY < 32


def test_a_condition_beside_the_arms_is_compared_with_the_truth():
    asked = families(study("why", agent="human-inspired", condition="nudge"), "human-inspired")
    assert asked[-1].questions == (Question("nudge", (("nudge", "truth"),)),)
    assert [family.questions[0].name for family in asked if family.after is None] == ["total", "nudge"]


def test_without_a_total_effect_there_is_nothing_to_explain():
    arms = {one.label: (np.zeros(150), np.zeros(150, dtype=bool)) for one in WHY.conditions}
    found = decisions(families(WHY, "human-inspired"), arms, DECIDED)
    assert {(one.verdict, one.at) for one in found} == {("small", found[0].at)}


def test_contrasts_are_explained_by_the_effect_of_their_own_modality():
    """In words of positions every lie helps; of outcomes alone none does anything."""
    shown = ["symbolic", "symbolic?tell=outcome"]
    specs = [one.spec for one in WHY.conditions[1:]]
    planned = study("flips", agent="human-inspired", p=[0], modality=shown, condition=specs)
    asked = families(planned, "human-inspired")
    solved = {(one.specs, "symbolic"): float(of) for one, of in zip(WHY.conditions, "0100110", strict=True)}
    arms = {
        one.label: (np.full(150, solved.get((one.specs, one.modality), 0.0)), np.zeros(150, dtype=bool))
        for one in planned.conditions
    }
    found = decisions(asked, arms, DECIDED)
    for modality in shown:
        own = {one.label for one in planned.conditions if one.modality == modality}
        alone = [one.verdict for one in found if one.question.labels <= own]
        assert ("effect" in alone) == (modality == "symbolic"), (modality, alone)
        assert {*alone} <= ({"effect", "not needed"} if modality == "symbolic" else {"small"}), (modality, alone)


@pytest.mark.parametrize("until", [DECIDED, WIDTH])
def test_of_a_single_condition_its_success_is_asked_for(until):
    planned = study("flips", agent="random", p=[0], until=str(until))
    assert families(planned, "random") == (Family((Question("truth", (("truth", ""),)),), 1),)
    solved = np.tile([0.0, 1, 1, 1], 100)
    (one,) = decisions(families(planned, "random"), {"truth": (solved, np.zeros(400, dtype=bool))}, until)
    assert (one.verdict, one.course.value) == ("narrow", 0.5)
    width = one.course.highs[one.course.blocks == one.at] - one.course.lows[one.course.blocks == one.at]
    assert width <= 4 * until.points


def test_what_breaks_could_have_made_decides_nothing():
    """Nothing is different; failures break under the one condition and successes under the other, a third of each."""
    rng, blocks = np.random.default_rng(3), 400
    solved = rng.random((2, blocks)) < 0.5
    broke = np.stack([~solved[0], solved[1]]) & (rng.random(solved.shape) < 1 / 3)
    asked = [Family((Question("a", (("a", "t"),)),), 1)]
    known = {label: (np.where(broke[i], np.nan, solved[i]), broke[i]) for i, label in enumerate("ta")}
    ended = {label: (values, np.zeros(blocks, bool)) for label, (values, _) in known.items()}
    ((without,), (found,)) = (decisions(asked, one, DECIDED) for one in (ended, known))
    assert without.verdict == "effect"
    assert found.verdict is None
    filled = [
        {label: (np.where(broke[i], end ^ i, solved[i]), np.zeros(blocks, bool)) for i, label in enumerate("ta")}
        for end in (0, 1)
    ]
    ((first,), (second,)) = (decisions(asked, one, DECIDED) for one in filled)
    assert (found.course.lows == np.minimum(first.course.lows, second.course.lows)).all()
    assert (found.course.highs == np.maximum(first.course.highs, second.course.highs)).all()
