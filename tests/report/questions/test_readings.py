"""What a false report is: the shares that were false, what the reading changes."""

import pytest
from builders import write_study
from reported import tables_of

from lockprobe.report.format import entry_text
from lockprobe.report.results import results
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load

AGENT, BLIND = "cognitive:perseverant", "random"
KEPT = "flip?p=0.4&others=kept"


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    asked = {"agent": [AGENT, BLIND], "p": [0, 0.4, 0.6], "flip": "re-observed,integrated", "trials": 20, "seed": 3}
    planned = study("flips", **asked, condition="no-feedback=drop?p=1", repetitions=1)
    return write_study(tmp_path_factory.mktemp("readings") / "study", planned)


@pytest.fixture(scope="module")
def found(directory):
    return results(directory)


def table(found, name):
    head, *rows = tables_of(found)[name]
    return [dict(zip(head, row, strict=True)) for row in rows]


def test_the_shares_of_false_outcomes_and_positions_are_counted_in_the_records(found, directory):
    trials = load(directory)
    own = [trial for trial in trials if (trial.agent, trial.condition) == (AGENT, KEPT)]
    pairs = [pair for trial in own for pair in zip(trial.steps, trial.steps[1:], strict=False)]
    false = sum(step.told_state != later.state for step, later in pairs)
    row = found.one("false_report", of="positions", agent=AGENT, condition=KEPT)
    assert 0 <= row.count - false <= len(own)  # of the last report of each trial no later state is on record
    outcomes = found.one("false_report", agent=AGENT, condition=KEPT, of="steps")
    assert outcomes.count == sum(step.told_falsely for trial in own for step in trial.steps)
    fresh = found.one("false_report", of="positions", agent=AGENT, condition="flip?p=0.4")
    assert fresh.value < 0.6 < row.value
    assert found.one("false_report", of="positions", agent=AGENT, condition="truth").count == 0


def test_readings_are_compared_in_pairs_at_the_same_rate(found):
    shown = [row for row in table(found, "effects") if row["agent"] == AGENT and row["control"].startswith("flip")]
    assert [(row["condition"], row["control"]) for row in shown] == [
        (f"flip rate {rate}, false reports that stay", f"flip rate {rate}") for rate in ("0.4", "0.6")
    ]
    gap = found.one("success_difference", agent=AGENT, condition=KEPT, control="flip?p=0.4")
    assert shown[0]["difference, points"] == entry_text(gap)
    kept, fresh = (found.one("success", agent=AGENT, condition=name) for name in (KEPT, "flip?p=0.4"))
    assert gap.value == pytest.approx(kept.value - fresh.value)
    assert found.where("success_difference", agent=BLIND, control="flip?p=0.4") == []  # it plays alike
