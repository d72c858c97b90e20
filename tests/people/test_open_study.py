"""A study is opened for people, beside models that play it, and what was killed is mended."""

import asyncio
import json
import os
import stat
from collections import Counter
from dataclasses import replace

import pytest
from builders import with_right_checksums
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

from lockprobe.foundation.errors import BadFile, BadValue, DirectoryBusy, SettingsChanged, UserMistake
from lockprobe.interventions.conditions import flips, read_condition
from lockprobe.people.diary import Did, read_diaries
from lockprobe.people.experiment import Experiment
from lockprobe.people.open_study import LOG, words_to_read
from lockprobe.people.responses import Agree
from lockprobe.people.scenes import Box
from lockprobe.people.server_state import ServerState
from lockprobe.people.texts import TEXTS, read_words
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import LeftOut, left_out, load
from lockprobe.studies.records.trial_rows import Timing, read_timings
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


def forgotten(directory, lines=1):
    """As if the server had been killed after the last act was on disk, and before the trial was."""
    for name in ("trials.jsonl", "timings.jsonl"):
        whole = (directory / name).read_text().splitlines(keepends=True)
        (directory / name).write_text("".join(whole[:-lines]))


@pytest.mark.parametrize("modality", ["symbolic", "rgb"])
def test_a_trial_that_was_over_and_not_written_down_is_written_down(tmp_path, modality):
    if modality == "rgb":
        study = people_study(p=(0.0,), plant="fast-twin?width=64&height=64", modalities=("rgb",), max_steps=2, trials=1)
        (shown,) = take_part(tmp_path, study, short(), "round-robin")
    else:
        study = STUDY
        (shown,) = take_part(tmp_path, study, short())
    before, clocks = load(tmp_path), read_timings(tmp_path)
    files = (tmp_path / "trials.jsonl").read_bytes(), (tmp_path / "timings.jsonl").read_bytes()
    forgotten(tmp_path)
    assert len(load(tmp_path)) == len(before) - 1

    async def again():
        async with opened(tmp_path, study, short()) as reception:
            return await reception.enter(shown.token, {})

    assert asyncio.run(again()).scene == shown.scene
    assert ((tmp_path / "trials.jsonl").read_bytes(), read_timings(tmp_path)) == (files[0], clocks)
    assert (tmp_path / "timings.jsonl").read_bytes() == files[1]


def test_a_trial_that_cannot_be_played_again_as_it_was_stops_everything(tmp_path):
    (shown,) = take_part(tmp_path, STUDY, short())
    forgotten(tmp_path)
    path = tmp_path / "people" / f"{shown.identity}.jsonl"
    lines = path.read_text().splitlines(keepends=True)
    last = max(n for n, line in enumerate(lines) if '"scene":"box"' in line)
    path.write_text("".join(lines[: last - 1] + lines[last:]))
    with pytest.raises(BadFile, match=shown.identity):
        begun(tmp_path)


def test_a_diary_of_another_study_is_refused(tmp_path):
    shown = begun(tmp_path)
    path = tmp_path / "people" / f"{shown.identity}.jsonl"
    path.write_text(path.read_text().replace('"trial":1', '"trial":9'))
    with_right_checksums(path)
    with pytest.raises(BadFile, match="trials of another study"):
        begun(tmp_path)


def test_a_diary_whose_first_line_was_torn_is_nobody(tmp_path):
    shown = begun(tmp_path)
    path = tmp_path / "people" / f"{shown.identity}.jsonl"
    path.write_bytes(path.read_bytes().splitlines()[0][:-5])

    async def comes_back():
        async with opened(tmp_path, STUDY, short()) as reception:
            return (await reception.enter(shown.token, {})).scene.kind, len(read_diaries(tmp_path))

    assert asyncio.run(comes_back()) == ("consent", 0)


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
    slots = [diary_of(tmp_path, path.stem)[0].slots for path in (tmp_path / "people").glob("*.jsonl")]
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
    for path in (tmp_path / "people").glob("*.jsonl"):
        token = diary_of(tmp_path, path.stem)[0].token
        path.write_text(path.read_text().replace(token, ""))
        with_right_checksums(path)
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
    before = (tmp_path / "trials.jsonl").read_bytes()
    if lost:
        forgotten(tmp_path, 2)
        asyncio.run(opens(with_words(tmp_path, WORDS, page="3")))
    assert (tmp_path / "trials.jsonl").read_bytes() == before
    assert [trial.facts["page"] for trial in load(tmp_path)] == ["1", "2"]


def test_a_diary_that_was_copied_makes_no_second_participant(tmp_path):
    shown = begun(tmp_path)
    path = tmp_path / "people" / f"{shown.identity}.jsonl"
    path.with_name("abcd1234.jsonl").write_bytes(path.read_bytes())
    with pytest.raises(BadFile, match="another participant"):
        begun(tmp_path)


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
    assert left_out(here) == LeftOut(unfinished_lines=0, replaced=0, repeated=0)
    assert places == [3, 3]


def test_a_diary_that_was_copied_under_another_name_is_refused(tmp_path):
    identity = begun(tmp_path).identity
    diary = tmp_path / "people" / f"{identity}.jsonl"
    copy = diary.with_name("aaaa1111.jsonl")
    copy.write_bytes(diary.read_bytes().replace(identity.encode(), b"aaaa1111"))
    with_right_checksums(copy)
    with pytest.raises(BadFile, match="a copy of the diary"):
        begun(tmp_path)


def test_a_diary_that_tells_of_other_steps_than_the_record_is_refused(tmp_path):
    (shown,) = take_part(tmp_path, STUDY, short())
    diary = tmp_path / "people" / f"{shown.identity}.jsonl"
    lines = diary.read_text("utf-8").splitlines(keepends=True)
    at = max(i for i, line in enumerate(lines) if '"kind":"attempt"' in line)
    joint = json.loads(lines[at])["act"]["joint"]
    lines[at] = lines[at].replace(f'"joint":"{joint}"', '"joint":"%s"' % ("A" if joint != "A" else "B"))
    diary.write_text("".join(lines), "utf-8")
    with_right_checksums(diary)
    with pytest.raises(BadFile, match="its steps differ"):
        begun(tmp_path)


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
    return {path.relative_to(directory): path.read_bytes() for path in directory.rglob("*") if path.is_file()}


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


def test_once_somebody_has_joined_all_stays(tmp_path):
    async def serving():
        async with opened(tmp_path, STUDY, short()) as reception:
            shown = await reception.enter(None, {})
            await reception.act(shown.token, shown.lease, 1, Agree(agreed=True), {})
            raise Failed

    with pytest.raises(Failed):
        asyncio.run(serving())
    assert len(list((tmp_path / "people").glob("*.jsonl"))) == 1
    assert (tmp_path / "people" / "experiment.json").exists()
