"""A study is opened for people, beside models that play it, and what was killed is mended."""

import asyncio
import json
from dataclasses import replace

import pytest
from seated import Player, as_played, diary_of, go_on, opened, people_study, short, take_part, without_page

from lockprobe.errors import BadFile, BadValue, DirectoryBusy, SettingsChanged, UserMistake
from lockprobe.people.experiment import Experiment
from lockprobe.people.opening import practice_plan
from lockprobe.people.scenes import Box
from lockprobe.studies.journal import load, read_timings
from lockprobe.studies.runner import run_study
from lockprobe.studies.settings import read_study

STUDY = people_study()


def begun(directory, study=STUDY, experiment=None, **settings):
    """Somebody has joined."""
    experiment = experiment or short()
    return take_part(directory, study, experiment, until=lambda shown: isinstance(shown.scene, Box), **settings)[0]


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


def test_models_join_a_study_that_people_have_played(tmp_path):
    take_part(tmp_path, STUDY, short())
    with_models = replace(STUDY, agents=("participant", "random"))
    with pytest.raises(SettingsChanged):
        run_study(with_models, tmp_path)


@pytest.mark.parametrize("change", [{"seed": 8}, {"max_steps": 5}, {"p": (0.0,)}, {"assessment": False}])
def test_another_study_in_the_same_directory_is_refused(tmp_path, change):
    begun(tmp_path)
    take_part(tmp_path, STUDY, short())
    with pytest.raises(SettingsChanged):
        begun(tmp_path, replace(STUDY, **change))


@pytest.mark.parametrize(
    "change", [{"view": "text"}, {"feedback": True}, {"practice": "chain-2"}, {"design": "between"}]
)
def test_other_settings_are_refused_once_somebody_has_joined(tmp_path, change):
    take_part(tmp_path, STUDY, short(), until=lambda shown: shown.scene.kind == "consent")
    begun(tmp_path, experiment=short(**{"view": "panel", **change}))
    with pytest.raises(SettingsChanged, match=next(iter(change))):
        begun(tmp_path)


def test_how_many_may_come_and_where_they_go_on_can_be_changed(tmp_path):
    begun(tmp_path, experiment=short(participants=1))
    other = short(participants=2, completion_url="https://example.org/done", completion_code="C2", away_hours=2)
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


def test_the_practice_is_another_box_with_true_reports_for_everybody_the_same():
    study = people_study(p=(0.4,), layout="shuffled", max_steps=9)
    plan = practice_plan(study, Experiment(practice="chain-2"))
    assert (plan.p, plan.box.name, plan.budget, plan.modality) == (0.0, "chain-2", 9, "symbolic")
    assert plan == practice_plan(study, Experiment(practice="chain-2"))
    assert plan.seed != study.seed
    assert practice_plan(study, short()) is None
    pictured = people_study(p=(0.0,), plant="fast-twin", modalities=("rgb",))
    assert practice_plan(pictured, Experiment()).modality == "rgb"


def forgotten(directory, lines=1):
    """As if the server had been killed after the last act was on disk, and before the trial was."""
    for name in ("trials.jsonl", "timings.jsonl"):
        whole = (directory / name).read_text().splitlines(keepends=True)
        (directory / name).write_text("".join(whole[:-lines]))


@pytest.mark.parametrize("modality", ["symbolic", "rgb"])
def test_a_trial_that_was_over_and_not_written_down_is_written_down(tmp_path, modality):
    if modality == "rgb":
        study = people_study(p=(0.0,), plant="fast-twin", modalities=("rgb",), max_steps=2, trials=1)
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
    with pytest.raises(BadFile, match="trials of another study"):
        begun(tmp_path)


def test_a_diary_whose_first_line_was_torn_is_nobody(tmp_path):
    shown = begun(tmp_path)
    path = tmp_path / "people" / f"{shown.identity}.jsonl"
    path.write_bytes(path.read_bytes().splitlines()[0][:-5])

    async def comes_back():
        async with opened(tmp_path, STUDY, short()) as reception:
            return (await reception.enter(shown.token, {})).scene.kind, reception.progress().joined

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
        assert sorted(person[place].p for person in slots) == [0.0, 0.0, 0.2, 0.2, 0.4, 0.4]
