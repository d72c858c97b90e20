"""A study is opened for people, beside models that play it, and what was killed is mended."""

import asyncio
import json
import os
import stat
from collections import Counter
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from sqlite3 import connect

import pytest
from seated import (
    WORDS,
    Clock,
    Player,
    as_played,
    diary_of,
    free,
    go_on,
    opened,
    people_study,
    short,
    take_part,
    under,
    without_page,
)
from stored import acts, records, rewrite_acts, sql

from lockprobe.foundation.errors import BadFile, BadValue, DirectoryBusy, SettingsChanged, UserMistake
from lockprobe.interventions.conditions import flips, read_condition
from lockprobe.people.diary import Did, read_diaries
from lockprobe.people.experiment import Experiment
from lockprobe.people.open_study import LOG, words_to_read
from lockprobe.people.responses import Agree
from lockprobe.people.scenes import Box
from lockprobe.people.server_state import ServerState
from lockprobe.people.texts import TEXTS, read_words
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.store import STORE
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.studies.running.runner import run_study
from lockprobe.trial.condition import Condition

STUDY = people_study()


def begun(directory, study=STUDY, experiment=None, **settings):
    """Somebody has joined."""
    experiment = experiment or short()
    return take_part(directory, study, experiment, until=lambda shown: isinstance(shown.scene, Box), **settings)[0]


@pytest.mark.parametrize("there", [False, True])
def test_nobody_else_reads_what_people_did_whatever_the_umask(tmp_path, there):
    before = os.umask(0)
    try:
        if there:
            run_study(replace(STUDY, agents=("random",)), tmp_path / "study")
            assert stat.S_IMODE((tmp_path / "study").stat().st_mode) == 0o777
        take_part(tmp_path / "study", STUDY, short())
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "study").stat().st_mode) == 0o700


def test_a_start_that_fails_leaves_who_may_read_the_directory(tmp_path):
    run_study(replace(STUDY, agents=("random",)), tmp_path)
    tmp_path.chmod(0o755)
    (tmp_path / "people").mkdir()
    (tmp_path / "people" / "secret").mkdir()
    with pytest.raises(BadFile):
        begun(tmp_path)
    assert stat.S_IMODE(tmp_path.stat().st_mode) == 0o755


def test_people_join_a_study_that_models_have_played(tmp_path):
    models = replace(STUDY, agents=("random", "round-robin"))
    played = run_study(models, tmp_path)
    begun(tmp_path, STUDY)
    assert read_study(tmp_path).agents == ("random", "round-robin", "participant")
    take_part(tmp_path, STUDY, short(), people=2)
    trials = load(tmp_path)
    assert trials[: len(played)] == played
    assert all(map(read_study(tmp_path).asks_for, trials))
    assert run_study(read_study(tmp_path), tmp_path) == trials  # and models can go on beside them


def test_people_play_conditions_in_the_order_of_the_directory_whatever_the_order_asked_for(tmp_path):
    begun(tmp_path, STUDY)
    before = (tmp_path / "study.json").read_bytes()
    begun(tmp_path, replace(STUDY, conditions=STUDY.conditions[::-1]))
    assert (tmp_path / "study.json").read_bytes() == before


def test_a_named_agent_keeps_its_name_when_people_join(tmp_path):
    run_study(replace(STUDY, agents=("random",), names={"random": "blind"}), tmp_path)
    begun(tmp_path, STUDY)
    assert read_study(tmp_path).labels == ("blind", "participant")


def test_models_join_a_study_that_people_have_played(tmp_path):
    take_part(tmp_path, STUDY, short())
    played = load(tmp_path)
    both = run_study(replace(STUDY, agents=("random", "participant")), tmp_path)
    assert both[: len(played)] == played
    assert read_study(tmp_path).agents == ("random", "participant")
    take_part(tmp_path, STUDY, short())  # and people can go on beside them
    assert load(tmp_path)[: len(both)] == both


@pytest.mark.parametrize(
    "change", [{"seed": 8}, {"max_steps": 5}, {"conditions": flips((0.0,))}, {"assessment": False}]
)
def test_another_study_in_the_same_directory_is_refused(tmp_path, change):
    begun(tmp_path)
    take_part(tmp_path, STUDY, short())
    with pytest.raises(SettingsChanged):
        begun(tmp_path, replace(STUDY, **change))


@pytest.mark.parametrize(
    "change", [{"history": False}, {"feedback": True}, {"practice": "chain-2"}, {"design": "between"}]
)
def test_other_settings_are_refused_once_somebody_has_joined(tmp_path, change):
    take_part(tmp_path, STUDY, short(), until=lambda shown: shown.scene.kind == "consent")
    begun(tmp_path, experiment=short(**change))
    with pytest.raises(SettingsChanged, match=next(iter(change))):
        begun(tmp_path)


def test_how_many_may_come_and_where_they_go_on_can_be_changed(tmp_path):
    begun(tmp_path, experiment=short(participants=1))
    other = short(participants=2, completion_url="https://example.org/done", completion_code="C2", away_minutes=2)
    assert begun(tmp_path, experiment=other).identity
    assert json.loads((tmp_path / "people" / "experiment.json").read_text())["participants"] == 2


def test_two_servers_cannot_have_one_directory(tmp_path):
    async def both():
        async with opened(tmp_path, STUDY, short()), opened(tmp_path, STUDY, short()):
            pass

    with pytest.raises(DirectoryBusy):
        asyncio.run(both())


@pytest.mark.parametrize(
    ("study", "settings", "error"),
    [
        (STUDY, {"practice": "no-such-box"}, UserMistake),
        (STUDY, {"trials_each": 5}, BadValue),
        (STUDY, {"checks": [{"after": 3, "question": "?", "options": ["a", "b"], "right": "a"}]}, BadValue),
    ],
)
def test_what_cannot_be_had_is_said_before_anybody_comes(tmp_path, study, settings, error):
    with pytest.raises(error):
        begun(tmp_path / "new", study, Experiment(**settings))
    assert not (tmp_path / "new" / "people").exists()


def test_what_people_cannot_play_is_refused_however_it_is_on_disk(tmp_path):
    run_study(replace(STUDY, agents=("random",), conditions=(Condition(), read_condition("history?last=3"))), tmp_path)
    kept = replace(read_study(tmp_path), agents=("random", "participant"))
    assert kept.conditions[1].is_recorded
    with pytest.raises(BadValue, match="condition: got 'history.last=3', expected what is told or done"):
        begun(tmp_path, kept)
    assert not (tmp_path / "people").exists()


def test_english_words_are_refused_beside_texts_in_another_language(tmp_path):
    german = read_words("de")
    for spec in ("nudge", "warn", "correction?p=1"):
        with pytest.raises(BadValue, match="texts: got 'de', expected English ones with"):
            asyncio.run(opens(with_words(tmp_path, german, study=under("truth", spec))))
    assert list(tmp_path.iterdir()) == []
    asyncio.run(opens(with_words(tmp_path, german, study=under("truth", "drop?p=0.3 + tremble?p=0.1"))))


def forgotten(directory, trials=1):
    """As if the server had been killed after the last act was on disk, and before the trial was."""
    sql(directory, "delete from trial where id in (select id from trial order by id desc limit ?)", trials)


@pytest.mark.parametrize("modality", ["symbolic", "rgb"])
def test_a_trial_that_was_over_and_not_written_down_is_written_down(tmp_path, modality):
    if modality == "rgb":
        study = people_study(p=(0.0,), plant="fast-twin?width=64&height=64", modalities=("rgb",), max_steps=2, trials=1)
        (shown,) = take_part(tmp_path, study, short(), "round-robin")
    else:
        study = STUDY
        (shown,) = take_part(tmp_path, study, short())
    before = sql(tmp_path, "select * from trial")
    forgotten(tmp_path)
    assert sql(tmp_path, "select * from trial") == before[:-1]

    async def again():
        async with opened(tmp_path, study, short()) as reception:
            return await reception.enter(shown.token, {})

    assert asyncio.run(again()).scene == shown.scene
    assert sql(tmp_path, "select * from trial") == before


def _without_a_step(lines):
    del lines[min(n for n, line in enumerate(lines) if line.get("box") == 2)]
    for turn, line in enumerate(lines[1:], 2):
        line["turn"] = turn


def _with_another_last_step(lines):
    last = [line for line in lines if line.get("scene") == "box"][-1]
    last["act"]["joint"] = "A" if last["act"]["joint"] != "A" else "B"


def _with_other_trials(lines):
    lines[0]["slots"][0]["trial"] = 9


@pytest.mark.parametrize("recorded", [True, False])
@pytest.mark.parametrize(
    ("change", "said"),
    [
        (_without_a_step, {True: "its steps differ from the record of flips", False: "step .* as it was shown before"}),
        (
            _with_another_last_step,
            {True: "its steps differ from the record of flips", False: "step .* as it was shown before"},
        ),
        (_with_other_trials, dict.fromkeys((True, False), "trials of another study")),
    ],
)
def test_a_diary_that_disagrees_with_the_record_or_with_what_is_played_again_is_named(tmp_path, recorded, change, said):
    (shown,) = take_part(tmp_path, STUDY, short())
    if not recorded:
        forgotten(tmp_path)
    lines = acts(tmp_path, shown.identity)
    change(lines)
    rewrite_acts(tmp_path, shown.identity, lines)
    with pytest.raises(BadFile, match=f"study.db: participant {shown.identity}: {said[recorded]}"):
        begun(tmp_path)


def test_a_copy_of_a_diary_makes_no_second_participant(tmp_path):
    identity = begun(tmp_path).identity
    joined, *rest = acts(tmp_path, identity)
    rewrite_acts(tmp_path, "aaaa1111", [joined | {"identity": "aaaa1111"}, *rest])
    with pytest.raises(BadFile, match="a copy of the diary"):
        begun(tmp_path)


def test_everybody_goes_on_after_a_restart_and_balance_is_kept(tmp_path):
    study = people_study(p=(0.0, 0.2, 0.4), trials=6)
    left = [begun(tmp_path, study) for _ in range(3)]

    async def go_on_together():
        async with opened(tmp_path, study, short()) as reception:
            back = [await reception.enter(shown.token, {}) for shown in left]
            assert [shown.scene for shown in back] == [shown.scene for shown in left]
            await asyncio.gather(
                *(go_on(reception, Player(tmp_path, study, "ideal-observer"), shown) for shown in back)
            )

    asyncio.run(go_on_together())
    take_part(tmp_path, study, short(), "ideal-observer", people=3)
    trials = load(tmp_path)
    assert len({trial.key for trial in trials}) == len(trials) == study.size
    for trial in trials:
        assert as_played(trial) == as_played(without_page(study, trial, "ideal-observer"))
    slots = [diary.joined.slots for diary in read_diaries(tmp_path)]
    for place in range(3):
        assert Counter(person[place].condition for person in slots) == {one.label: 2 for one in study.conditions}


def with_words(directory, words, page="1", study=STUDY, **settings):
    """Opened with other texts or another page."""
    return ServerState.open(directory, study, short(**settings), words, clock=Clock(), page=page)


async def opens(context):
    async with context as reception:
        return len([*reception._roster])


def test_other_texts_are_refused_once_somebody_has_joined_and_the_same_from_another_file_are_not(tmp_path):
    edited = WORDS.model_copy(update={"title": "Another title"})
    assert asyncio.run(opens(with_words(tmp_path, edited))) == 0
    begun(tmp_path)
    with pytest.raises(SettingsChanged, match="texts is 'en "):
        asyncio.run(opens(with_words(tmp_path, edited)))
    assert asyncio.run(opens(with_words(tmp_path, WORDS, language="elsewhere/english.toml"))) == 1


def test_texts_of_people_who_came_from_elsewhere_are_theirs(tmp_path):
    take_part(tmp_path, STUDY, short())
    for diary in read_diaries(tmp_path):
        joined, *rest = acts(tmp_path, diary.identity)
        rewrite_acts(tmp_path, diary.identity, [joined | {"token": ""}, *rest])
    assert asyncio.run(opens(with_words(tmp_path, WORDS.model_copy(update={"title": "Another title"})))) == 1


@pytest.mark.parametrize("lost", [False, True])
def test_a_record_names_the_page_on_which_the_box_was_begun(tmp_path, lost):
    (left,) = take_part(tmp_path, STUDY, short(), until=lambda one: isinstance(one.scene, Box) and one.scene.step == 2)

    async def goes_on():
        async with with_words(tmp_path, WORDS, page="2") as reception:
            await go_on(
                reception, Player(tmp_path, STUDY, "round-robin"), await reception.enter(left.token, {}), at_the_end
            )

    def at_the_end(shown):
        return shown.scene.kind == "over" and shown.scene.number == 2

    asyncio.run(goes_on())
    before = sql(tmp_path, "select * from trial")
    if lost:
        forgotten(tmp_path, 2)
        asyncio.run(opens(with_words(tmp_path, WORDS, page="3")))
    assert sql(tmp_path, "select * from trial") == before
    assert [trial.facts["page"] for trial in load(tmp_path)] == ["1", "2"]


def test_who_plays_a_trial_that_came_from_elsewhere_finished_goes_on_with_the_next(tmp_path):
    here, there = tmp_path / "here", tmp_path / "there"
    (left,) = take_part(here, STUDY, short(), until=lambda one: isinstance(one.scene, Box) and one.scene.step == 3)
    take_part(there, STUDY, short())
    comes = load(there)[0]
    slot = diary_of(here, left.identity)[0].slots[0]
    assert (comes.condition, comes.repetition, comes.trial) == (slot.condition, slot.repetition, slot.trial)
    with Journal.open(here, STUDY) as journal:
        journal.append(comes, Timing(key=comes.key, seconds=1.0, steps=len(comes.steps)))

    async def comes_back():
        async with opened(here, STUDY, short()) as reception:
            shown = await reception.enter(left.token, {})
            assert (shown.scene.kind, shown.scene.number, shown.scene.solved) == ("over", 1, None)
            await go_on(reception, Player(here, STUDY, "round-robin"), shown)
            return free(reception)

    places = asyncio.run(comes_back())
    assert isinstance(diary_of(here, left.identity)[-1], Did)
    assert [trial.agent for trial in load(here)] == [comes.agent, f"participant:{left.identity}"]
    assert len(records(here)) == 2
    assert places == [3, 3]


def test_without_its_secret_a_study_with_participants_is_not_opened(tmp_path):
    begun(tmp_path)
    (tmp_path / "people" / "secret").unlink()
    with pytest.raises(BadFile, match="Restore it"):
        begun(tmp_path)


def test_texts_that_change_with_a_release_are_not_those_of_who_takes_part_already(tmp_path):
    assert words_to_read(tmp_path, Experiment()) == WORDS
    begun(tmp_path)
    copy = tmp_path / "people" / TEXTS
    before = copy.read_text("utf-8")
    copy.write_text(before.replace("Before you begin", "As it was in the release before"), "utf-8")
    assert words_to_read(tmp_path, Experiment()).consent.title == "As it was in the release before"
    own = tmp_path / "own.toml"
    own.write_text(before, "utf-8")
    assert words_to_read(tmp_path, Experiment(language=str(own))) == WORDS


STUDY = people_study()


class Failed(Exception):
    """The server cannot start."""


def everything(directory):
    """The content of all files; of the store what is in its tables."""
    there = {path.relative_to(directory): path.read_bytes() for path in directory.rglob("*") if path.is_file()}
    with closing(connect(directory / STORE)) as store:
        return there | {Path(STORE): [*store.iterdump()]}


def fail(directory, experiment=None, *, invited=False):
    """A server that fails when its directory is open already."""

    async def serving():
        async with opened(directory, STUDY, experiment or short()) as reception:
            (directory / "people" / LOG).touch()
            if invited:
                reception.invite()
            raise Failed

    with pytest.raises(Failed):
        asyncio.run(serving())


def test_a_new_study_is_gone(tmp_path):
    fail(tmp_path / "runs" / "study")
    assert list(tmp_path.iterdir()) == []


def test_a_study_of_models_is_as_it_was(tmp_path):
    with Journal.open(tmp_path, people_study(agents=("random",))):
        pass
    before = everything(tmp_path)
    fail(tmp_path)
    assert everything(tmp_path) == before
    assert not (tmp_path / "people").exists()


def test_settings_of_people_are_as_they_were(tmp_path):
    take_part(tmp_path, STUDY, short(), until=lambda shown: isinstance(shown.scene, Box))
    before = everything(tmp_path)
    fail(tmp_path, short(participants=2, away_minutes=3))
    assert everything(tmp_path) == before


def test_a_secret_that_is_lost_changes_no_settings(tmp_path):
    take_part(tmp_path, STUDY, short(), until=lambda shown: isinstance(shown.scene, Box))
    (tmp_path / "people" / "secret").unlink()
    before = everything(tmp_path)

    async def serving():
        async with ServerState.open(tmp_path, STUDY, short(participants=2), WORDS):
            pass

    with pytest.raises(BadFile, match="Restore it"):
        asyncio.run(serving())
    assert everything(tmp_path) == before


def test_once_people_are_invited_all_stays(tmp_path):
    fail(tmp_path / "study", invited=True)
    there = {path.name for path in (tmp_path / "study" / "people").iterdir()}
    assert {"experiment.json", "secret", LOG} <= there
    assert (tmp_path / "study" / "study.json").exists()


@pytest.mark.parametrize("there", [False, True])
def test_once_somebody_has_joined_all_stays(tmp_path, there):
    if there:  # the directory of people alone, as after its texts were put there
        (tmp_path / "people").mkdir()

    async def serving():
        async with opened(tmp_path, STUDY, short()) as reception:
            shown = await reception.enter(None, {})
            await reception.act(shown.token, shown.lease, 1, Agree(agreed=True), {})
            raise Failed

    with pytest.raises(Failed):
        asyncio.run(serving())
    assert len(read_diaries(tmp_path)) == 1
    assert (tmp_path / "people" / "experiment.json").exists()
