"""Records on disk: round trip and refusal."""

import math
from dataclasses import replace

import pytest

from lockprobe import run_trial
from lockprobe.foundation.errors import BadValue
from lockprobe.trial.trial_json import trial_from_json, trial_to_json


def test_a_record_survives_the_disk():
    trial = run_trial(agent="human-inspired", p=0.4)
    assert trial_from_json(trial_to_json(trial)) == trial


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        (b'"ending":"solved"', b'"ending":"won"', "ending"),
        (b'"seed":1', b'"seed":"one"', "seed"),
        (b'"key":', b'"kee":', "key"),
        (b"/rep=1/", b"/rep=2/", "key: got '.*/rep=2/trial=1', expected .*/rep=1/trial=1"),
        (b'"condition":"truth"', b'"condition":"lie"', "key: got 'trial/.*/truth/rep=1/trial=1'"),
        (b'"joint":"revolute-left"', b'"joint":"lever"', "joint: got 'lever'"),
        (b'"state":"0000"', b'"state":"00"', "state: got '00'"),
        (b'"step":2', b'"step":3', "step 2, number: got 3"),
        (b'"budget":20', b'"budget":3', "at most the budget of 3"),
        (b'"ending":"budget"', b'"ending":"solved"', "a last step that moved the target"),
        (b'"target":"revolute-left"', b'"target":"lid"', "target: got 'lid'"),
    ],
)
def test_a_line_that_is_no_trial_is_refused_with_the_place(old, new, where):
    agent = "random" if b'"budget"' in old else "human-inspired"  # the one fails, the other solves
    line = trial_to_json(run_trial(agent=agent, seed=1))
    assert old in line
    with pytest.raises(BadValue, match=where):
        trial_from_json(line.replace(old, new))


@pytest.mark.parametrize(
    ("odd", "where"),
    [
        ({"specs": ("flip?p=2",), "doses": {"flip.p": 2.0}}, "flip.p: got 2.0"),
        ({"doses": {"flip.p": math.nan}}, "doses.flip.p"),
        ({"replays": -1}, "replays', expected a trial .* at least 0|replays', expected a trial .*equal to 0"),
    ],
)
def test_a_value_that_no_trial_has_is_refused(odd, where):
    with pytest.raises(BadValue, match=where):
        trial_from_json(trial_to_json(replace(run_trial(agent="random"), **odd)))


@pytest.mark.parametrize("name", ["../../secret.png", "A" * 20 + ".png", "a" * 20 + ".png\n", ""])
def test_a_record_names_no_file_outside_its_directory(name):
    trial = run_trial(agent="human-inspired")
    first = replace(trial.steps[0], pictures={"rgb": name})
    for odd in (replace(trial, opening_pictures={"rgb": name}), replace(trial, steps=(first, *trial.steps[1:]))):
        with pytest.raises(BadValue, match="rgb picture"):
            trial_from_json(trial_to_json(odd))
    fine = replace(trial, opening_pictures={"rgb": "0123456789abcdef0123.png"})
    assert trial_from_json(trial_to_json(fine)) == fine
    assert fine.picture_names == {"0123456789abcdef0123.png"}


def test_a_trial_without_steps_is_no_trial():
    line = trial_to_json(run_trial())
    start, end = line.index(b'"steps":[') + 9, line.rindex(b'],"ending"')
    with pytest.raises(BadValue, match="expected a last step that moved the target"):
        trial_from_json(line[:start] + line[end:])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b'"ending":"solved"', b'"ending":"budget"', "solved, or no step that moved the target"),
        (b'"ending":"solved"', b'"ending":"error"', "error: got None, expected one exactly if the ending is error"),
        (b'"labels":["', b'"labels":["Z","', "labels: got"),
        (b'"solved"', b'"solved","solvd":true', "solvd"),
        (b'"budget":20', b'"budget":"20"', "budget"),
        (b'"budget":20', b'"budget":1000000', "at most the budget of 10000"),
        (b'"moved":true', b'"moved":"yes"', "moved"),
        (b'"told_state":"0001"', b'"told_state":"zzz"', "told state: got 'zzz'"),
    ],
)
def test_contradictions_are_refused(old, new, message):
    line = trial_to_json(run_trial(agent="human-inspired", seed=1))
    assert old in line
    with pytest.raises(BadValue, match=message):
        trial_from_json(line.replace(old, new, 1))


@pytest.mark.parametrize("chances", ["[-1,2,0,0]", "[1.0]", "[0.5,0.5,1e308,0]", "[0.25,0.25,0.25,NaN]"])
def test_probabilities_are_probabilities(chances):
    line = trial_to_json(run_trial(agent="human-inspired", seed=1))
    damaged = line.replace(b'"decision":{', b'"decision":{"probabilities":%s,' % chances.encode(), 1)
    with pytest.raises(BadValue, match="probabilities: got"):
        trial_from_json(damaged)


def test_a_trial_that_ran_out_of_steps_used_them_all():
    line = trial_to_json(run_trial(agent="random", seed=1))
    assert b'"ending":"budget"' in line
    with pytest.raises(BadValue, match="expected 21, since the steps ran out"):
        trial_from_json(line.replace(b'"budget":20', b'"budget":21'))


@pytest.mark.parametrize("number", [b"1e999", b"-1e999", b"NaN", b"1" + 400 * b"0"], ids=["inf", "-inf", "nan", "huge"])
@pytest.mark.parametrize(
    ("field", "changed"),
    [
        (b'"facts":{}', b'"facts":{"x":%s}'),
        (b'"channel":', b'"x":%s,"channel":'),
        (b'"told":', b'"sensed":{"x":%s},"told":'),
        (b'"ending":', b'"plant":{"x":%s},"ending":'),
        (b'"ending":', b'"replays":%s,"ending":'),
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


def test_the_largest_seed_is_read():
    line = trial_to_json(run_trial(seed=1)).replace(b'"seed":1', b'"seed":%d' % 2**63)
    assert trial_from_json(line).seed == 2**63
