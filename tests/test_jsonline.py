"""Records on disk: round trip, refusal, golden lines of every schema version."""

from pathlib import Path

import pytest

from lockprobe import run_trial
from lockprobe.errors import BadValue
from lockprobe.record import trial_from_json, trial_to_json

GOLDEN = Path(__file__).parent / "golden"


def test_a_record_survives_the_disk():
    trial = run_trial(agent="human-inspired", p=0.4)
    assert trial_from_json(trial_to_json(trial)) == trial


def test_golden_records_still_read():
    lines = (GOLDEN / "trials_v1.jsonl").read_bytes().splitlines()
    trials = [trial_from_json(line) for line in lines]
    assert [trial.ending for trial in trials] == ["solved", "budget", "error"]
    assert [trial_to_json(trial) for trial in trials] == lines


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        (b'"ending":"solved"', b'"ending":"won"', "ending"),
        (b'"seed":1', b'"seed":"one"', "seed"),
        (b'"schema":1', b'"schema":99', "schema version"),
        (b'"key":', b'"kee":', "key"),
    ],
)
def test_a_line_that_is_no_trial_is_refused_with_the_place(old, new, where):
    line = trial_to_json(run_trial())
    assert old in line
    with pytest.raises(BadValue, match=where):
        trial_from_json(line.replace(old, new))
