"""A study is made larger in its directory, which says how large it was before."""

import json
from dataclasses import replace

import pytest
from builders import write_study

from lockprobe.foundation.errors import BadFile, BadValue, SettingsChanged
from lockprobe.studies.decisions import block_orders
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.merge import gather, source_of_directory
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import run_study
from lockprobe.studies.until import Until

SMALL = study("flips", agent="random", p=[0, 0.4], repetitions=2, trials=2)


@pytest.fixture
def small(tmp_path):
    return write_study(tmp_path / "small", SMALL)


def test_it_keeps_its_trials_and_their_order(small):
    before = load(small)
    trials = run_study(replace(SMALL, repetitions=3, trials=4), small)
    found = read_study(small)
    (plan,) = found.earlier
    assert trials[:8] == before
    assert len(trials) == 24
    assert (plan.repetitions, plan.trials) == (2, 2)
    assert found.settings_hash == replace(SMALL, repetitions=3, trials=4).settings_hash
    assert block_orders(found)["random"].plans == ((2, 2), (3, 4))
    assert run_study(replace(SMALL, repetitions=3, trials=4), small) == trials
    assert read_study(small).earlier == (plan,)


def test_several_extensions_are_all_remembered(small):
    run_study(replace(SMALL, trials=3), small)
    run_study(study("flips", agent="random", p=[0, 0.4], until="decided", most=8), small)
    found = read_study(small)
    assert [one.trials for one in found.earlier] == [2, 3]
    assert (found.repetitions, found.trials, found.until) == (2, 4, Until(rule="decided"))
    run_study(study("flips", agent="random", p=[0, 0.4], until="±20", most=8), small)
    assert [one.trials for one in read_study(small).earlier] == [2, 3, 4]


@pytest.mark.parametrize("smaller", [{"trials": 1}, {"repetitions": 1}, {"trials": 9, "repetitions": 1}])
def test_a_smaller_one_is_refused(small, smaller):
    with pytest.raises(SettingsChanged, match="repeat its settings to resume it, or give another --out"):
        run_study(replace(SMALL, **smaller), small)
    run_study(replace(SMALL, trials=3), small)
    with pytest.raises(SettingsChanged):
        run_study(replace(SMALL, **smaller), small)
    with pytest.raises(SettingsChanged, match="until is 'never' there, '±5' asked"):
        run_study(replace(SMALL, trials=2, until=Until(rule="width", points=0.05)), small)
    assert len(load(small)) == 12


def test_another_agent_or_an_import_forgets_no_earlier_plan(small, tmp_path):
    run_study(replace(SMALL, trials=3), small)
    (plan,) = read_study(small).earlier
    with Journal.open(small, replace(SMALL, trials=3, agents=("round-robin",))):
        pass
    assert read_study(small).earlier == (plan,)
    assert read_study(small).agents == ("random", "round-robin")
    other = write_study(tmp_path / "other", replace(SMALL, trials=3, agents=("human-inspired",)))
    gather(tmp_path / "both", [source_of_directory(other), source_of_directory(small)])
    gather(other, [source_of_directory(small)])
    assert read_study(tmp_path / "both").earlier == read_study(other).earlier == (plan,)


def test_what_is_compared_at_one_look_is_not_extended(tmp_path):
    people = study("flips", box="chain-4", agent=["participant", "random"], p=[0], repetitions=1, trials=2)
    write_study(tmp_path / "people", people, [])
    run_study(people, tmp_path / "people")
    with pytest.raises(BadValue, match="trials: got 3, expected 2: people are compared at one look"):
        run_study(replace(people, trials=3), tmp_path / "people")


@pytest.mark.parametrize("change", [{"trials": 10**18}, {"trials": 3}, {"repetitions": 0}, {"until": None}, 3])
def test_settings_with_an_earlier_plan_that_was_no_smaller_are_refused_in_a_line(small, change):
    run_study(replace(SMALL, trials=3), small)
    settings = json.loads((small / SETTINGS).read_text())
    settings["trials"] = 2
    settings["earlier"] = [settings["earlier"][0] | change] if isinstance(change, dict) else change
    (small / SETTINGS).write_text(json.dumps(settings))
    with pytest.raises(BadFile) as refused:
        read_study(small)
    assert "\n" not in str(refused.value)
