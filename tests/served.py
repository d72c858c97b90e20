"""A study that is served, in this process, and visitors who come to it."""

import hashlib
from contextlib import asynccontextmanager
from types import SimpleNamespace

import httpx2 as httpx
from visitor import Visitor

from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import flips
from lockprobe.people.experiment import Experiment, read_words
from lockprobe.people.web import app
from lockprobe.people.web.address import Address
from lockprobe.people.web.app import opened
from lockprobe.studies.study import Study

STUDY = Study(
    name="flips",
    agents=("participant",),
    boxes=(box("chain-4"),),
    conditions=flips((0.0, 0.4)),
    repetitions=1,
    trials=3,
    max_steps=12,
)
QUESTIONS = {
    "questions": [{"name": "how", "question": "How?"}, {"name": "sure", "question": "?", "options": ["a", "b"]}]
}
EXPERIMENT = Experiment.model_validate({"practice": "", **QUESTIONS})


def experiment(**changes):
    return Experiment.model_validate(EXPERIMENT.model_dump() | changes)


@asynccontextmanager
async def served(directory, study=STUDY, people=EXPERIMENT, door=None):
    door = door or Address(port=0)
    async with (
        opened(directory, study, people, read_words("en"), door) as (where, state),
        httpx.AsyncClient(base_url=where.url, trust_env=False, verify=False, timeout=60) as http,
    ):
        yield SimpleNamespace(url=where.url, preview=state.preview, http=http, directory=directory, study=study)


@asynccontextmanager
async def visiting(place, **settings):
    visitor = Visitor(place.url, place.study, place.directory, **settings)
    try:
        yield visitor
    finally:
        await visitor.close()


async def at_the_box(visitor, step=1):
    """A visitor who has come as far as a step of the first box."""
    await visitor.open()
    while visitor.scene["kind"] != "box" or visitor.scene["step"] < step:
        await visitor.do()


def written(directory):
    """Every byte of a directory but the locks of readers."""
    files = sorted(path for path in directory.rglob("*") if path.is_file() and path.name != "study.db-shm")
    return {str(path): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def logged(caplog):
    """The lines of the log since it was looked at last, without their times."""
    said = [one.getMessage().partition("Z ")[2] for one in caplog.records if one.name == app.__name__]
    caplog.clear()
    return said
