"""The study ``why``: its arms hit the same steps, and it says what it cannot have."""

import pytest

import lockprobe
from lockprobe.foundation.errors import BadValue, UserMistake
from lockprobe.statistics.arms import ARMS, CROSSED
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
