"""The study ``why``: its arms hit the same steps, and it says what it cannot have."""

import pytest

import lockprobe
from lockprobe.analysis.why_arms import ARMS
from lockprobe.errors import BadValue, UserMistake
from lockprobe.studies.studyfile import study
from lockprobe.studies.why import AGENTS, EXTENT


def test_without_options_it_plays_every_arm_at_the_papers_rate():
    planned = study("why")
    assert (planned.name, planned.agents, planned.repetitions * planned.trials) == ("why", AGENTS, 150)
    assert [one.label for one in planned.conditions] == list(ARMS)
    assert [one.spec for one in planned.conditions] == [spec.format(p=EXTENT.p[0]) for spec in ARMS.values()]


def test_every_arm_hits_the_steps_at_which_the_lie_is_told():
    """A blind agent acts alike in every arm, so that its steps are the same."""
    told = {
        arm: lockprobe.run_trial(agent="round-robin", condition=condition, trial=2, box="chain-5")
        for arm, condition in zip(ARMS, study("why").conditions, strict=True)
    }
    lies = [step.told_falsely for step in told["lie"].steps]
    assert 3 < sum(lies) < 17
    for arm in ("retracted", "confirmed"):
        assert ["Correction:" in step.told for step in told[arm].steps] == lies
        assert not any(step.told_falsely for step in told[arm].steps)
    first = lies.index(True) + 1  # what is not reported is not known to have been attempted, so that then they part
    assert [step.told_moved is None for step in told["withheld"].steps[:first]] == lies[:first]
    assert [step.told_falsely for step in told["lie + remark"].steps] == lies
    hit = [step.chosen is not None for step in told["tremble"].steps]
    assert all(lie for trembled, lie in zip(hit, lies, strict=False) if trembled)


def test_other_conditions_come_after_the_arms():
    planned = study("why", p=[0.2], condition="flip?p=0.2&while=looping", agent="random", trials=2)
    assert [one.label for one in planned.conditions][-1] == "flip?p=0.2&while=looping"
    assert planned.conditions[1].specs == ("flip?p=0.2",)


def test_it_is_shown_in_one_way_throughout():
    planned = study("why", modality="symbolic", agent="random")
    assert {one.modality for one in planned.conditions} == {"symbolic"}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"p": [0]}, "a rate above 0"),
        ({"p": [0.2, 0.4]}, "one, which all arms have"),
        ({"p": [1.5]}, "a rate above 0"),
        ({"modality": ["rgb"], "plant": "fast-twin"}, "pictures cannot be corrected"),
        ({"modality": ["symbolic", "symbolic?tell=state"]}, "one, which all arms have"),
        ({"flip": "integrated"}, "re-observed"),
        ({"condition": "flip?p=0.4"}, "another condition than the arm lie, which is the same"),
        ({"condition": "nudge"}, "got 'nudge', expected another condition than the arm nudge, which is the same"),
        ({"condition": "retracted=nudge?after=5"}, r"got 'retracted=nudge.*another name: retracted is the arm correc"),
        ({"condition": "warn + symbolic"}, "none that is shown otherwise than all arms, symbolic.tell=state"),
    ],
)
def test_what_it_cannot_have_is_one_line(options, said):
    with pytest.raises(UserMistake, match=said) as caught:
        study("why", **options)
    assert isinstance(caught.value, BadValue)
    assert "\n" not in str(caught.value)
