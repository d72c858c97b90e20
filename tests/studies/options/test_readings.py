"""What a false report is: readings side by side, and rates that are read from another study."""

import json
from dataclasses import replace
from shutil import rmtree

import pytest

from lockprobe.foundation.errors import BadFile, BadValue, UnknownName
from lockprobe.interventions.conditions import interventions_in
from lockprobe.interventions.misread_flip import rates_of
from lockprobe.report.verify import verify
from lockprobe.statistics.misinterpretation import claim_counts, misread_rates
from lockprobe.studies.options.asked_conditions import READINGS
from lockprobe.studies.options.presets import preset
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import run_study

MODEL, STRATEGY = "llm:local", "random"
FULL = preset("flips")
SHORT = FULL.when["short"]
KEPT = [f"flip?p={p:g}&others=kept" for p in SHORT.p if p]


def labels(planned, agent=None):
    own = planned.conditions if agent is None else planned.conditions_of(agent)
    return [one.label for one in own]


def test_words_name_readings_and_all_are_the_two_by_two():
    fresh, kept, sticky, transient = (
        labels(study("flips", agent=STRATEGY, p=[0.4], readings=word))
        for word in ("fresh", "kept", "sticky", "transient")
    )
    assert [fresh, kept] == [["flip?p=0.4"], ["flip?p=0.4&others=kept"]]
    assert [sticky, transient] == [["flip?p=0.4&inverts=position&others=kept"], ["flip?p=0.4&inverts=position"]]
    planned = study("flips", agent=STRATEGY, p=[0, 0.4], readings="all")
    assert labels(planned) == [
        "truth", "flip?p=0.4", "flip?p=0.4&others=kept", "flip?p=0.4&inverts=position",
        "flip?p=0.4&inverts=position&others=kept",
    ]  # fmt: skip
    assert [interventions_in(one)[0].reading for one in planned.conditions[1:]] == [
        "re-observed outcome noise", "integrated outcome noise", "memoryless state noise", "latched state noise",
    ]  # fmt: skip
    assert len(READINGS) == 4


def test_the_short_study_and_the_papers_play_lies_that_stay_where_that_costs_nothing():
    short, full = (study("flips", agent=[MODEL, STRATEGY], full=whole) for whole in (False, True))
    rates = [f"flip?p={p:g}" for p in SHORT.p if p]
    assert labels(short, MODEL) == ["truth", "flip?p=0.4"]
    assert labels(short, STRATEGY) == ["truth", *rates, *KEPT, "no-feedback"]
    assert short.size_of(MODEL) == 2 * FULL.repetitions * SHORT.trials
    assert labels(study("flips", agent=MODEL), MODEL) == ["truth", *rates]  # which nobody else would play
    assert len(labels(full, STRATEGY)) == 2 * len(FULL.p) - 1
    assert labels(full, MODEL) == labels(full)[: len(FULL.p)]


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"readings": "afresh"}, "readings: got 'afresh', expected one of fresh, kept, "),
        (
            {"readings": "fresh,re-observed"},
            "readings: got 'fresh,re-observed', expected at least one, and every one once",
        ),
        ({"readings": "all", "flip": "sticky"}, "readings: got 'all', expected none with --flip sticky"),
        ({"readings": "all", "study": "why"}, "readings: got 'all', expected none with why; flips plays them"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_line(asked, said):
    with pytest.raises(BadValue) as refused:
        study(asked.pop("study", "flips"), **asked)
    assert str(refused.value).startswith(said)


THERE = study("flips", agent="cognitive:perseverant", p=[0, 0.4], trials=6, repetitions=1)


def like(there, **more):
    """A study with the rates of another one."""
    asked = {"agent": "human-inspired", "condition": f"flip?like={there}/flip?p=0.4", "trials": 4, "repetitions": 1}
    return study("flips", **asked | more)


def test_misreadings_of_another_study_are_a_condition_of_this_one(tmp_path):
    """The rates stand in the settings, so the other study may go; no path stands in a key."""
    run_study(THERE, tmp_path / "there")
    here = like(tmp_path / "there")
    said = claim_counts(trial for trial in load(tmp_path / "there") if trial.condition == "flip?p=0.4")
    matrix = misread_rates(said, THERE.box.names)
    rmtree(tmp_path / "there")
    trials = run_study(here, tmp_path / "here")
    condition = here.conditions[1]
    assert rates_of(condition.interventions[0].rates) == {
        joint: pytest.approx(rates, abs=1e-5) for joint, rates in matrix.items()
    }
    assert condition.interventions[0].size == said.total() > 20
    assert condition.label == "flip?p=1&like=flips/flip?p=0.4"
    assert str(tmp_path) not in json.dumps(here.settings())
    told = [trial for trial in trials if trial.condition == condition.label]
    assert any(step.told_falsely for trial in told for step in trial.steps)
    for trial in told:
        entries = rates_of(tuple(str(trial.channels[0]["by_label"]).split(";")))
        labelled = dict(zip(trial.labels, trial.joints, strict=True))
        for label, rates in entries.items():
            assert rates == pytest.approx(matrix[labelled[label]], abs=1e-5)
    assert read_study(tmp_path / "here").identity == here.identity
    assert [check.name for check in verify(tmp_path / "here") if not check.holds] == []


def test_a_source_that_does_not_fit_is_refused_before_anything_is_played(tmp_path):
    run_study(THERE, tmp_path / "there")
    run_study(replace(THERE, name="silent", assessment=False), tmp_path / "silent")
    for given, said in (
        ({"box": "chain-3"}, "expected a study of chain-3, not of chain-4"),
        ({"condition": f"flip?like={tmp_path}/there/rgb"}, "no condition in .* is called 'rgb'"),
        ({"condition": f"flip?like={tmp_path}/silent/truth"}, "whose agent said what its attempts did"),
        ({"condition": f"flip?like={tmp_path}/there/truth&of=random"}, "of: got 'random', expected an agent of"),
        ({"condition": "flip?like=truth"}, "DIR/CONDITION, with the directory of a finished study"),
    ):
        with pytest.raises((BadValue, UnknownName), match=said):
            like(tmp_path / "there", **given)
    with pytest.raises(BadFile):
        like("nowhere")
    other = like(tmp_path / "there", box="chain-3", condition=f"flip?like={tmp_path}/there/flip?p=0.4&by=total")
    rates = rates_of(other.conditions[1].interventions[0].rates)
    assert set(rates) == set(other.box.names)
    assert len({*rates.values()}) == 1
