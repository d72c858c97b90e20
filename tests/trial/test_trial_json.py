"""Records on disk: round trip, refusal, and reading many as each alone, with equal parts as one object."""

import math
from dataclasses import FrozenInstanceError, replace

import pytest
from builders import make_trial

from lockprobe import run_trial
from lockprobe.foundation.errors import BadValue
from lockprobe.trial.trial_json import TrialReader, trial_from_json, trial_to_json

SOLVED, FAILED = (trial_to_json(run_trial(agent=agent, seed=2)) for agent in ("human-inspired", "random"))


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        (b'"ending":"solved"', b'"ending":"won"', "ending"),
        (b'"seed":2', b'"seed":"one"', "seed"),
        (b'"key":', b'"kee":', "key"),
        (b"/rep=1/", b"/rep=2/", "key: got '.*/rep=2/trial=1', expected .*/rep=1/trial=1"),
        (b'"condition":"truth"', b'"condition":"lie"', "key: got 'trial/.*/truth/rep=1/trial=1'"),
        (b'"joint":"revolute-left"', b'"joint":"lever"', "joint: got 'lever'"),
        (b'"state":"0000"', b'"state":"00"', "state: got '00'"),
        (b'"step":2', b'"step":3', "numbers of steps: got .1, 3"),
        (b'"budget":20', b'"budget":3', "at most the budget of 3"),
        (b'"ending":"budget"', b'"ending":"solved"', "a last step that moved the target"),
        (b'"target":"revolute-left"', b'"target":"lid"', "target: got 'lid'"),
        (b'"ending":"solved"', b'"ending":"budget"', "solved, or no step that moved the target"),
        (b'"ending":"solved"', b'"ending":"error"', "error: got None, expected one exactly if the ending is error"),
        (b'"labels":["', b'"labels":["Z","', "labels: got"),
        (b'"solved"', b'"solved","solvd":true', "solvd"),
        (b'"budget":20', b'"budget":"20"', "budget"),
        (b'"budget":20', b'"budget":1000000', "at most the budget of 10000"),
        (b'"moved":true', b'"moved":"yes"', "moved"),
        (b'"told_state":"0001"', b'"told_state":"zzz"', "told state: got 'zzz'"),
        (b'"budget":20', b'"budget":21', "expected 21, since the steps ran out"),
        *(
            (b'"decision":{', b'"decision":{"probabilities":%s,' % chances, "probabilities")
            for chances in (b"[-1,2,0,0]", b"[1.0]", b"[0.5,0.5,1e308,0]", b"[0.25,0.25,0.25,NaN]")
        ),
    ],
)
def test_a_line_that_is_no_trial_is_refused_with_the_place(old, new, where):
    line = FAILED if b'"budget"' in old and b'"20"' not in new else SOLVED
    assert old in line
    with pytest.raises(BadValue, match=where):
        trial_from_json(line.replace(old, new))


@pytest.mark.parametrize(
    ("odd", "where"),
    [
        ({"specs": ("flip?p=2",), "doses": {"flip.p": 2.0}}, "flip.p: got 2.0"),
        ({"doses": {"flip.p": math.nan}}, "doses.flip.p"),
        ({"changed": {"flip?p=1": 99}}, "steps changed by flip.p=1: got 99, expected 0 to"),
        ({"changed_steps": -1}, "changed_steps"),
        ({"steps": ()}, "expected a last step that moved the target"),
    ],
)
def test_a_value_that_no_trial_has_is_refused(odd, where):
    with pytest.raises(BadValue, match=where):
        trial_from_json(trial_to_json(replace(run_trial(seed=1), **odd)))


@pytest.mark.parametrize("name", ["../../secret.png", "A" * 20 + ".png", "a" * 20 + ".png\n", ""])
def test_a_record_names_no_file_outside_its_directory(name):
    trial = trial_from_json(SOLVED)
    first = replace(trial.steps[0], pictures={"rgb": name})
    for odd in (replace(trial, opening_pictures={"rgb": name}), replace(trial, steps=(first, *trial.steps[1:]))):
        with pytest.raises(BadValue, match="pictures.rgb"):
            trial_from_json(trial_to_json(odd))
    fine = replace(trial, opening_pictures={"rgb": "0123456789abcdef0123.png"})
    assert trial_from_json(trial_to_json(fine)) == fine
    assert fine.picture_names == {"0123456789abcdef0123.png"}


@pytest.mark.parametrize("number", [b"1e999", b"-1e999", b"NaN", b"1" + 400 * b"0"], ids=["inf", "-inf", "nan", "huge"])
@pytest.mark.parametrize(
    ("field", "changed"),
    [
        (b'"facts":{}', b'"facts":{"x":%s}'),
        (b'"channel":', b'"x":%s,"channel":'),
        (b'"told":', b'"sensed":{"x":%s},"told":'),
        (b'"ending":', b'"plant":{"x":%s},"ending":'),
        (b'"ending":', b'"changed_steps":%s,"ending":'),
        (b'"ending":', b'"doses":{"x":%s},"ending":'),
        (b'"repetition":1', b'"repetition":%s'),
        (b'"trial":1', b'"trial":%s'),
        (b'"seed":1', b'"seed":%s'),
    ],
)
def test_no_number_of_a_record_is_beyond_what_can_be_exported(field, changed, number):
    line = trial_to_json(run_trial(seed=1))
    assert field in line
    with pytest.raises(BadValue, match="trial record"):
        trial_from_json(line.replace(field, changed % number, 1))
    assert trial_from_json(line.replace(b'"seed":1', b'"seed":%d' % 2**63)).seed == 2**63  # the largest


def test_equal_steps_and_equal_settings_are_one_object():
    reader = TrialReader()
    first, second = (
        reader.read(trial_to_json(replace(make_trial([0, 1, 2], trial=number), budget=3, ending="budget")))
        for number in (1, 2)
    )
    assert first != second
    assert all(one is other for one, other in zip(first.steps, second.steps, strict=True))
    with pytest.raises(FrozenInstanceError):  # or a change of one trial would be one of others
        first.steps[0].moved = True
    assert first.facts is second.facts
    assert first.doses is second.doses
