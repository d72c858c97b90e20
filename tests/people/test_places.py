"""A study is opened for people, beside models that play it; places are as many as there are, and each trial is played once."""

import asyncio
import json
import os
import stat
from collections import Counter
from dataclasses import replace

import pytest
from painted import painted_twins
from seated import (
    WORDS,
    Clock,
    Player,
    an_act,
    diary_of,
    free,
    go_on,
    opened,
    people_study,
    refused,
    short,
    take_part,
    to_first,
    under,
)  # fmt: skip
from stored import acts, rewrite_acts, sql

from lockprobe.foundation.errors import BadFile, SettingsChanged, UserMistake
from lockprobe.people.diary import read_diaries
from lockprobe.people.experiment import Experiment, read_words
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import run_study

STUDY, HOURS = people_study(), 3600.0


def at_first_step(shown):
    return shown.scene.kind == "box" and shown.scene.step == 2


def begun(directory, study=STUDY, experiment=None, **settings):
    """Somebody has joined."""
    return take_part(directory, study, experiment or short(), until=lambda one: one.scene.kind == "box", **settings)[0]


def test_nobody_else_reads_what_people_did_whatever_the_umask(tmp_path):
    before = os.umask(0)
    try:
        run_study(replace(STUDY, agents=("random",)), tmp_path / "study")
        take_part(tmp_path / "study", STUDY, short())
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "study").stat().st_mode) == 0o700


def test_people_and_models_join_each_other_whatever_they_are_called_and_whatever_the_order_of_conditions(tmp_path):
    played = run_study(replace(STUDY, agents=("random",), names={"random": "blind"}), tmp_path)
    begun(tmp_path)
    before = (tmp_path / "study.json").read_bytes()
    begun(tmp_path, replace(STUDY, conditions=STUDY.conditions[::-1]))
    assert (tmp_path / "study.json").read_bytes() == before
    assert read_study(tmp_path).labels == ("blind", "participant")
    take_part(tmp_path, STUDY, short(), people=2)
    trials = load(tmp_path)
    assert trials[: len(played)] == played
    both = run_study(replace(read_study(tmp_path), agents=("round-robin",), names={}), tmp_path)
    assert {trial.group for trial in both} == {"blind", "round-robin", "participant"}
    assert load(tmp_path)[: len(trials)] == trials


@pytest.mark.parametrize(
    "change", [{"history": False}, {"feedback": True}, {"practice": "chain-2"}, {"trials_each": 1}]
)
def test_other_settings_are_refused_once_somebody_has_joined_but_for_those_of_places_and_ends(tmp_path, change):
    take_part(tmp_path, STUDY, short(), until=lambda shown: shown.scene.kind == "consent")
    begun(tmp_path, experiment=short(**change, participants=1))
    with pytest.raises(SettingsChanged, match=next(iter(change))):
        begun(tmp_path)
    ends = {"completion_url": "https://example.org/done", "completion_code": "C2", "away_minutes": 2}
    assert begun(tmp_path, experiment=short(**change, **ends, participants=2)).participant
    assert json.loads((tmp_path / "people" / "experiment.json").read_text())["participants"] == 2


def test_other_texts_are_refused_once_somebody_who_can_come_back_has_read_these(tmp_path):
    async def opens(words, **settings):
        async with opened(tmp_path, STUDY, short(**settings), words=words) as reception:
            return len(reception.sessions)

    edited = WORDS.model_copy(update={"title": "Another title"})
    assert asyncio.run(opens(edited)) == 0
    begun(tmp_path)
    with pytest.raises(SettingsChanged, match="texts is 'en "):
        asyncio.run(opens(edited))
    assert asyncio.run(opens(WORDS, language="elsewhere/english.toml")) == 1
    assert read_words(str(tmp_path / "people" / "texts.toml")) == WORDS


CHECK = {"question": "?", "options": ["a", "b"], "right": "a"}


@pytest.mark.parametrize(
    ("specs", "settings", "words", "error"),
    [
        ((), {"practice": "no-such-box"}, "en", "no box is called"),
        ((), {"trials_each": 5}, "en", "trials_each: got 5"),
        ((), {"checks": [{"after": 3, **CHECK}]}, "en", "checks, after: got 3"),
        (("truth", "nudge"), {}, "de", "texts: got 'de', expected English ones with nudge"),
        (("truth", "correction?p=1"), {}, "de", "expected English ones with"),
        (("truth", "history?last=3"), {}, "en", "condition: got 'history?last=3', expected what is told or done"),
    ],
)
def test_what_cannot_be_had_is_said_before_anything_is_written(tmp_path, specs, settings, words, error):
    async def opens():
        study = under(*specs) if specs else STUDY
        async with opened(tmp_path / "new", study, Experiment(**settings), words=read_words(words)):
            pass

    with pytest.raises(UserMistake, match=error.replace("?", r"\?")):
        asyncio.run(opens())
    assert list(tmp_path.iterdir()) == []


def forgotten(directory):
    """As if the server had been killed after the last act was on disk, and before the trial was."""
    sql(directory, "delete from trial where id in (select id from trial order by id desc limit 1)")


@pytest.mark.parametrize("modality", ["symbolic", "rgb"])
def test_a_trial_that_was_over_and_not_written_down_is_written_down(tmp_path, monkeypatch, modality):
    painted_twins(monkeypatch)
    pictures = {
        "p": (0.0,), "plant": "fast-twin?width=64&height=64", "modalities": ("rgb",), "max_steps": 2, "trials": 1,
    }  # fmt: skip
    study = people_study(**(pictures if modality == "rgb" else {}))
    (shown,) = take_part(tmp_path, study, short(), "round-robin")
    before = sql(tmp_path, "select * from trial")
    forgotten(tmp_path)

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


@pytest.mark.parametrize("change", [_without_a_step, _with_another_last_step])
def test_a_diary_that_disagrees_with_what_is_played_again_is_named(tmp_path, change):
    (shown,) = take_part(tmp_path, STUDY, short())
    forgotten(tmp_path)
    lines = acts(tmp_path, shown.participant)
    change(lines)
    rewrite_acts(tmp_path, shown.participant, lines)
    with pytest.raises(BadFile, match=f"study.db: participant {shown.participant}: step .* as it was shown before"):
        begun(tmp_path)


def test_what_was_finished_is_not_recorded_as_its_replay_if_that_breaks(tmp_path, monkeypatch):
    def stuck(plant, joint):
        raise OSError("stuck")

    take_part(tmp_path, STUDY, short())
    forgotten(tmp_path)
    monkeypatch.setattr(SymbolicPlant, "attempt", stuck)
    with pytest.raises(BadFile, match="the replay of box 2 ends differently from the play"):
        begun(tmp_path)


@pytest.mark.parametrize(
    ("study", "settings", "people", "kinds"),
    [
        ({}, {}, 7, {"debrief": 4, "closed": 3}),
        ({}, {"participants": 2, "recruitment": ()}, 3, {"debrief": 2, "closed": 1}),  # nobody knows who they are
        ({"trials": 1}, {"trials_each": 1}, 3, {"debrief": 2, "closed": 1}),
        ({"trials": 5}, {}, 12, {"debrief": 5, "closed": 7}),
    ],
)
def test_as_many_take_part_as_there_is_room_for_at_once_and_each_trial_is_played_once(
    tmp_path, study, settings, people, kinds
):
    platform = {"PROLIFIC_PID": "ann"} if "recruitment" in settings else {}
    last = take_part(tmp_path, people_study(**study), short(**settings), people=people, platform=platform)
    assert Counter(shown.scene.kind for shown in last) == kinds
    assert {shown.scene.why for shown in last if shown.scene.kind == "closed"} == {"full"}
    keys = [trial.key for trial in load(tmp_path)]
    assert len(keys) == len(set(keys)) == sum(len(diary.joined.slots) for diary in read_diaries(tmp_path))


def test_as_long_as_nobody_needs_the_place_nobody_is_sent_away_and_who_comes_back_goes_on(tmp_path):
    clock = Clock()
    (left,) = take_part(tmp_path, STUDY, short(), until=at_first_step, clock=clock)
    clock.now += 1000 * HOURS
    take_part(tmp_path, STUDY, short(), clock=clock, platform={"PROLIFIC_PID": "ann"})  # finds a free place

    async def comes_back():
        async with opened(tmp_path, STUDY, short(participants=2), clock=clock) as reception:
            for who, why in (("ann", "finished"), ("bob", None)):  # only bob could join if somebody left
                shown = await reception.enter(None, {"PROLIFIC_PID": who})
                assert shown.scene.get("why") == why
            first = await reception.enter(left.token, {})
            assert (first.scene, first.turn) == (left.scene, left.turn)
            assert (await reception.enter(None, {})).scene.why == "full"  # who has just come back stays
            player = Player(tmp_path, STUDY, "round-robin")
            on = await go_on(reception, player, first, lambda shown: shown.scene.kind == "over")
            clock.now += 1000 * HOURS
            on = await reception.act(on.token, on.turn, an_act(on.scene), {})  # in the same tab
            return await go_on(reception, player, on)

    assert asyncio.run(comes_back()).scene.kind == "debrief"
    assert ([diary.boxes_done for diary in read_diaries(tmp_path)], len(load(tmp_path))) == ([True] * 2, 4)


def test_whose_place_was_given_away_does_not_go_on_in_the_same_tab_or_later_or_with_more_time(tmp_path):
    clock, study = Clock(), people_study(trials=2)
    take_part(tmp_path, study, short(), clock=clock)
    (left,) = take_part(tmp_path, study, short(), until=lambda shown: shown.scene.kind == "over", clock=clock)

    async def comes_back(experiment):
        async with opened(tmp_path, study, experiment, clock=clock) as reception:
            tab = await reception.enter(left.token, {})
            if tab.scene.kind != "closed":
                clock.now += 23 * HOURS
                assert (await reception.enter(None, {})).scene.why == "full"
                clock.now += 2 * HOURS
                new = await to_first("box", reception, await reception.enter(None, {}))
                assert len(diary_of(tmp_path, new.participant)[0].slots) == 1
                assert await refused(reception, tab, an_act(tab.scene)) == "stale"
            again = await reception.enter(left.token, {})
            assert again.scene.why == "late"
            assert again.participant
            return free(reception)

    for experiment in (short(), short(away_minutes=100_000)):
        assert asyncio.run(comes_back(experiment)) == [0, 0]
    assert len(load(tmp_path)) == 3  # what was finished stays
