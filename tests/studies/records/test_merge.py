"""What was played elsewhere is taken in once, and only if it is of the same study."""

import asyncio
from dataclasses import replace

import pytest
from builders import call_of, make_trial, play_study, small_study, write_study
from stored import call_log, contents, records, rewrite, sql
from taking_part import take_part

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.interventions.conditions import flips
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.merge import gather
from lockprobe.studies.records.read_records import load
from lockprobe.trial.pictures.picture import Picture

ALL = small_study(p=[0.0, 0.4], trials=2)


def only(*agents):
    return replace(ALL, agents=agents)


def write_calls(directory, calls):
    """A study directory with these calls."""
    with call_log(directory) as log:
        for call in calls:
            asyncio.run(log.write(call))
    return directory


def test_what_is_there_is_left_alone_what_is_owed_is_taken_and_what_sources_have_alike_is_no_difference(tmp_path):
    """Whether they overlap whole or in part, come twice, or hold what broke here before."""
    study = small_study(["random", "round-robin"], trials=2, repetitions=1)
    trials = play_study(study)
    broken = [replace(one, ending="error", error=make_trial((), broken="model").error, steps=()) for one in trials[:1]]
    for name, held in {"a": trials[:8], "b": trials[4:], "c": trials, "d": broken}.items():
        write_study(tmp_path / name, study, held)
    sources = [tmp_path / name for name in "abc"]
    for directory in (tmp_path / "new", tmp_path / "d"):
        found = gather(directory, sources)
        assert (found.taken, found.there, found.different) == (12, 16, 0)
        assert read_study(directory) == study
        assert {trial.key: trial for trial in load(directory)} == {trial.key: trial for trial in trials}
        before = records(directory)
        again = gather(directory, [*sources, sources[0]])
        assert (again.taken, again.there, again.different, again.agents) == (0, 36, 0, ())
        assert records(directory) == before
    odd = replace(trials[5], opening="other words")
    write_study(tmp_path / "e", study, [odd])
    found = gather(tmp_path / "newer", [sources[0], tmp_path / "e"])
    assert (found.taken, found.there, found.different) == (8, 1, 1)


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"seed": 2}, "seed is 2, not 1"),
        ({"conditions": flips((0.0, 0.5))}, r"conditions is 'truth; flip\?p=0.5', not 'truth; flip\?p=0.4'"),
    ],
)
def test_trials_of_another_study_are_refused_in_one_line(tmp_path, other, said):
    here = write_study(tmp_path / "here", only("random"))
    there = write_study(tmp_path / "there", replace(only("human-inspired"), **other))
    before = read_study(here)
    with pytest.raises(BadFile, match=said):
        gather(here, [there])
    assert read_study(here) == before
    assert len(load(here)) == 8


def test_another_model_under_the_same_name_is_refused(tmp_path):
    trials = [make_trial([0] * 20, facts={"model": "x", "runtime": name}, trial=i) for i, name in ((1, "a"), (2, "b"))]
    here = write_study(tmp_path / "here", only("random"), trials[:1])
    there = write_study(tmp_path / "there", only("random"), trials[1:])
    with pytest.raises(BadFile, match="random is not the same there"):
        gather(here, [there])
    assert len(load(here)) == 1


def test_pictures_and_calls_come_along(tmp_path):
    png = Picture(kind="rgb", png=b"x" * 9)
    names = [{"rgb": png.name}, {"rgb": "0" * 20 + ".png"}]
    trial = make_trial([0] * 20, pictures=names)
    there = write_study(tmp_path / "there", only("random"), [trial])
    (there / "pictures").mkdir()
    (there / "pictures" / png.name).write_bytes(png.png)
    call = call_of(trial)
    write_calls(there, [call])
    gather(tmp_path / "here", [there])
    assert (tmp_path / "here" / "pictures" / png.name).read_bytes() == png.png
    assert list(read_calls(tmp_path / "here")) == [call]


PLANS = [plan for plan in only("random").plans("random") if plan.label == "truth"]


def asked(trial, step=1, reply="{}"):
    plan = next(plan for plan in PLANS if (plan.repetition, plan.trial) == (1, trial))
    return call_of(plan, step, reply, request=f"of {step}", error="" if reply else "no")


def with_calls(directory, calls, trials=()):
    """A study directory in which this was asked."""
    write_study(directory, only("random"), trials)
    return write_calls(directory, calls)


@pytest.mark.parametrize("new", [True, False])
@pytest.mark.parametrize("stop", [KeyboardInterrupt, BadFile("there", "is gone")])
def test_an_import_that_is_broken_off_took_nothing_and_counts_no_call_twice(tmp_path, monkeypatch, new, stop):
    trials = [make_trial([0] * 20, trial=i, pictures=[{"rgb": "0" * 20 + ".png"}]) for i in (1, 2)]
    calls = [asked(2), asked(1, reply=None), asked(1, reply=None), asked(1), asked(2, 2)]
    there, here = with_calls(tmp_path / "there", calls, trials), tmp_path / "here"
    if not new:
        write_study(here, only("round-robin"))
    before, append = contents(here), Journal.append

    def broken_off(journal, trial, seconds, record=None):
        if trial.trial == 2:
            raise stop
        append(journal, trial, seconds, record)

    with monkeypatch.context() as broken:
        broken.setattr(Journal, "append", broken_off)
        with pytest.raises((KeyboardInterrupt, BadFile)):
            gather(here, [there])
    if stop is not KeyboardInterrupt:
        assert (contents(here), here.exists()) == (before, not new)
    assert list(read_calls(here)) == []
    assert not any(trial.spec == "random" for trial in load(here)) if here.exists() else new
    assert gather(here, [there]).taken == 2
    assert sorted(map(repr, read_calls(here))) == sorted(map(repr, calls))


def test_what_was_paid_for_a_trial_that_is_not_finished_comes_along_and_is_gone_on_from(tmp_path):
    broken = make_trial([0], trial=2, broken="model")
    calls = [asked(1), asked(1, 2), asked(2), asked(2, 2, reply=None)]
    there = with_calls(tmp_path / "there", calls, [broken])
    here = tmp_path / "here"
    gathered = gather(here, [there])
    assert (gathered.taken, gathered.unfinished, gathered.replies, gathered.agents) == (0, 2, 3, ("random",))
    assert list(read_calls(here)) == calls
    with Journal.open(here, read_study(here)) as journal:
        assert journal.calls.of(PLANS[0]).recall(2, 1, "of 2") == calls[1]
    assert gather(here, [there]).replies == 0
    assert list(read_calls(here)) == calls


def test_of_two_beginnings_the_one_that_is_there_goes_on_and_its_own_continuation_is_taken(tmp_path):
    here = with_calls(tmp_path / "here", [asked(1), asked(2, reply="mine")])
    there = with_calls(tmp_path / "there", [asked(1), asked(1, 2), asked(2), asked(2, 2)])
    assert gather(here, [there]).replies == 1
    assert list(read_calls(here)) == [asked(1), asked(2, reply="mine"), asked(1, 2)]


PEOPLE = only("participant")


def test_people_of_two_places_are_one_group_and_each_trial_is_played_once(tmp_path):
    here, there = tmp_path / "here", tmp_path / "there"
    take_part(here, PEOPLE, "aaaa01", [(0.4, 1, 1)])
    mine = records(here)
    take_part(there, PEOPLE, "bbbb02", [(0.4, 1, 1), (0.0, 1, 2)])
    gathered = gather(here, [there])
    assert (gathered.taken, gathered.there, gathered.agents) == (1, 1, ())
    assert records(here)[:1] == mine
    assert [trial.agent for trial in load(here)] == ["participant:aaaa01", "participant:bbbb02"]


def test_nobody_comes_in_under_an_id_that_is_none(tmp_path):
    there = tmp_path / "there"
    take_part(there, PEOPLE, "aaaa01", [(0.4, 1, 1)])
    (record,) = records(there)
    rewrite(there, [record | {"agent": "participant:../../x"}], sql(there, "select identity from trial"))
    with pytest.raises(BadValue, match="participant:ID with 4 to 32"):
        gather(tmp_path / "here", [there])
    assert not (tmp_path / "here").exists()
