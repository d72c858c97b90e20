"""A study is made larger in its directory, which says how large it was before."""

from dataclasses import replace

import pytest
from builders import write_study

from lockprobe.foundation.errors import BadValue, SettingsChanged
from lockprobe.report.verify import verify
from lockprobe.studies.decisions import block_orders
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.merge import gather
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import run_study
from lockprobe.studies.study import Until

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
    (check,) = (one for one in verify(small, settings=SMALL.settings_hash) if one.name == "settings hash")
    assert check.failed[0].endswith(f"not {SMALL.settings_hash}, which they had before the study was extended")


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
    gather(tmp_path / "both", [other, small])
    gather(other, [small])
    assert read_study(tmp_path / "both").earlier == read_study(other).earlier == (plan,)


def test_what_is_compared_at_one_look_is_not_extended(tmp_path):
    people = study("flips", box="chain-4", agent=["participant", "random"], p=[0], repetitions=1, trials=2)
    write_study(tmp_path / "people", people, [])
    run_study(people, tmp_path / "people")
    with pytest.raises(BadValue, match="trials: got 3, expected 2: people are compared at one look"):
        run_study(replace(people, trials=3), tmp_path / "people")
