"""The studies with conditions of their own: ``why``, whose arms hit the same steps, ``looks``, a factorial design, and those in files."""

from itertools import combinations

import numpy as np
import pytest

import lockprobe
from lockprobe.foundation.errors import BadValue, UserMistake
from lockprobe.statistics.arms import ARMS, CROSSED
from lockprobe.studies.options.study_options import SHIPPED
from lockprobe.studies.options.studyfile import study


def test_without_options_it_plays_every_arm_at_the_papers_rate():
    planned = study("why")
    assert (planned.name, planned.agents[0], planned.repetitions) == ("why", "cognitive:insistent", 1)
    assert [one.label for one in planned.conditions] == list(ARMS)
    assert [one.spec for one in planned.conditions] == [spec.format(p="0.4", reading="") for spec in ARMS.values()]


@pytest.mark.parametrize("flip", ["re-observed", "integrated", "memoryless", "latched", "outcome-only"])
def test_the_lies_of_all_arms_are_of_the_kind_that_is_asked_for(flip):
    """A blind agent acts alike in every arm; so what is told last is equal where the last statement is a lie."""
    planned = study("why", flip=flip, agent="round-robin")
    told = {
        one.label: [
            (step.told_moved, step.told_state)
            for step in lockprobe.run_trial(agent="round-robin", condition=one, box="chain-5").steps
        ]
        for one in planned.conditions
    }
    assert told["truth-lie"] == told["lie-lie"] == told["lie"] != told["truth"]
    assert told["truth-truth"] == told["lie-truth"] == told["remark"] == told["truth"]


def test_parts_of_a_false_report_are_arms_on_request_in_reports_that_have_both_parts():
    planned = study("why", parts=True, agent="random")
    assert [one.label for one in planned.conditions] == [
        *ARMS,
        "false outcome",
        "false position",
        "phantom",
        "hidden moves",
        "invented moves",
    ]
    assert {one.modality for one in planned.conditions} == {"symbolic"}


def test_every_arm_hits_the_steps_at_which_the_lie_is_told():
    """A blind agent acts alike in every arm, so that its steps are the same."""
    told = {
        arm: lockprobe.run_trial(agent="round-robin", condition=condition, trial=2, box="chain-5")
        for arm, condition in zip(ARMS, study("why").conditions, strict=True)
    }
    lies = [step.told_falsely for step in told["lie"].steps]
    assert 3 < sum(lies) < 17
    for arm in CROSSED:
        assert ["Correction:" in step.told for step in told[arm].steps] == lies
        assert [step.told_falsely for step in told[arm].steps] == (lies if arm.endswith("lie") else [False] * len(lies))
    first, last = (
        [words.strip() for words in told[arm].steps[lies.index(True)].told.split("Correction:")]
        for arm in ("lie-truth", "truth-lie")
    )
    assert first == last[::-1] != last
    assert [bool(step.remark) for step in told["remark"].steps[1:]] == lies[:-1]


def test_other_conditions_come_after_the_arms():
    planned = study("why", p=[0.2], condition="flip?p=0.2&while=looping", agent="random", trials=2)
    assert [one.label for one in planned.conditions][-1] == "flip?p=0.2&while=looping"
    assert planned.conditions[1].specs == ("flip?p=0.2",)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"p": [0]}, "another condition than truth, which is the same"),
        ({"full": True}, "full: got True, expected none with why"),
        ({"p": [0.2, 0.4]}, "one, which all arms have"),
        ({"p": [1.5]}, "flip rate p: got 1.5"),
        ({"modality": ["rgb"], "plant": "fast-twin"}, "pictures cannot be corrected"),
        ({"modality": ["symbolic", "symbolic?tell=state"]}, "one, which all conditions of why have"),
        ({"flip": "independent"}, "others: got 'noisy', expected one of fresh, kept"),
        ({"parts": True, "modality": "symbolic?tell=state"}, "both with symbolic.tell=state"),
        ({"condition": "flip?p=0.4"}, "another condition than lie, which is the same"),
        ({"condition": "lie-lie=nudge?after=5"}, r"got 'lie-lie=nudge.*another name: lie-lie is correction"),
        ({"condition": "warn + symbolic"}, "none that is shown otherwise than all others, symbolic.tell=state"),
    ],
)
def test_what_it_cannot_have_is_one_line(options, said):
    with pytest.raises(UserMistake, match=said) as caught:
        study("why", **options)
    assert isinstance(caught.value, BadValue)
    assert "\n" not in str(caught.value)


FACTORS = {
    "discs": "no", "handle_colours": "plain", "labels": "no", "clutter": "8", "light": "side", "colours": "second",
    "viewpoint": "oblique", "view_jitter": "5",
}  # fmt: skip


def test_its_scenes_are_a_factorial_design_of_all_factors_and_each_has_its_contrast():
    """No factor is mixed with another, or with an interaction of two (resolution IV)."""
    found = study("looks")
    signs = np.array([[1 if name in one.plant.options else -1 for name in FACTORS] for one in found.conditions])
    assert (signs.shape, len({*map(tuple, signs)}), {*signs[0]}) == ((16, 8), 16, {-1})
    pairs = [first * second for first, second in combinations(signs.T, 2)]
    for column in signs.T:
        assert column.sum() == 0
        assert not any(column @ pair for pair in pairs)
    assert [*found.contrasts] == [f"{name}={high}" for name, high in FACTORS.items()]
    for column, one in zip(signs.T, found.contrasts.values(), strict=True):
        named = {label for label, sign in zip([one.label for one in found.conditions], column, strict=True) if sign > 0}
        assert (one.measure, {*one.of}, len(one.minus)) == ("misreading", named, 8)
    assert len(found.conditions) == len(found.plants) == 16
    assert (found.conditions[0].label, found.plant_of(found.conditions[0])) == ("plain scene", "fast-twin")
    assert (found.layout, found.trials, found.repetitions) == ("shuffled", 10, 1)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"modality": ["rgb", "rgbd"]}, "expected one, which all conditions of looks have"),
        ({"plant": "fast-twin?discs=no"}, "one without discs=no, which this study varies"),
        ({"sweep": "plant.pose_error=0,1"}, "none with looks"),
        ({"agent": "human-inspired"}, "human-inspired"),
    ],
)
def test_what_it_refuses(options, said):
    with pytest.raises(BadValue, match=said):
        study("looks", **options)


@pytest.mark.parametrize("name", SHIPPED)
def test_what_ships_is_a_study(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = study(name)
    assert found.p == tuple(round(0.1 * i, 1) for i in range(11))
    assert found.repetitions * found.trials >= 300
