"""A start that fails before people are invited leaves the directory as it was."""

import asyncio

import pytest
from seated import WORDS, opened, people_study, short, take_part

from lockprobe.errors import BadFile
from lockprobe.people.directory import LOG
from lockprobe.people.responses import Agree
from lockprobe.people.scenes import Box
from lockprobe.people.server_state import Reception
from lockprobe.studies.journal import Journal

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
    fail(tmp_path, short(participants=2, away_hours=3))
    assert everything(tmp_path) == before


def test_a_secret_that_is_lost_changes_no_settings(tmp_path):
    take_part(tmp_path, STUDY, short(), until=lambda shown: isinstance(shown.scene, Box))
    (tmp_path / "people" / "secret").unlink()
    before = everything(tmp_path)

    async def serving():
        async with Reception.open(tmp_path, STUDY, short(participants=2), WORDS):
            pass

    with pytest.raises(BadFile, match="Put it back"):
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
