"""Agents outside of the loop: a trial waits at each decision and goes on after it was let go of, under conditions that reach them."""

import asyncio
from dataclasses import replace

import pytest
from seated import people_study, without_page
from seen import PhotographedPlant

from lockprobe.foundation.errors import BadFile, BadValue, ChannelFault
from lockprobe.foundation.spec import PEOPLE
from lockprobe.interventions.conditions import flips, read_condition
from lockprobe.plants import catalogue
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.paused_trial import PausedTrial, RecordedAttempt
from lockprobe.studies.running.playable import CLIENT, PERSON, check_playable
from lockprobe.trial.record import Briefing

STUDY = people_study(layout="shuffled")
PLAN = STUDY.plan(f"{PEOPLE}:3f9a01bc", STUDY.labelled("flip?p=0.4"), 1, 2)


def steps_of(trial):
    """A trial as its steps are on disk."""
    labels = dict(zip(trial.joints, trial.labels, strict=True))
    return [RecordedAttempt(labels[step.joint], step.decision.claimed, step.told) for step in trial.steps]


@pytest.fixture(scope="module")
def alone():
    blank = asyncio.run(_blank())
    return without_page(STUDY, blank, "human-inspired")


async def begun(played=()):
    return await PausedTrial(PLAN).begin(played)


async def _blank():
    held = await begun()
    for _ in range(PLAN.budget):
        if held.trial is None:
            await held.attempt(held.situation.task.joints[0])
    return held.trial


@pytest.mark.parametrize(
    "wrong", [{"told": "A moved. At 1: none."}, {"joint": "Z"}], ids=["another report", "no such joint"]
)
def test_another_history_is_never_shown(alone, wrong):
    played = steps_of(alone)
    said = {"joint": played[1].joint, "claimed": played[1].claimed, "told": played[1].told}
    with pytest.raises(BadValue, match=r"step 2 of flips/participant/flip\?p=0\.4/rep=1/trial=2"):
        asyncio.run(begun([played[0], RecordedAttempt(**(said | wrong)), *played[2:4]]))


def test_pictures_are_kept_and_are_no_words(tmp_path, monkeypatch):
    source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: PhotographedPlant(box))
    monkeypatch.setattr("lockprobe.plants.catalogue.resolve_plant", lambda spec: source)
    plan = replace(PLAN, condition=flips((0.0,), modalities=("rgb",))[0])

    async def looked() -> None:
        held = await PausedTrial(plan, pictures=tmp_path).begin()
        told = [await held.attempt("A") for _ in range(2)]
        assert told == ["", ""]
        names = [picture.name for picture in held.situation.percept.pictures]
        assert set(names) <= {path.name for path in tmp_path.iterdir()}
        await held.close()
        full = tmp_path / "file"
        full.write_text("")
        with pytest.raises(BadFile):
            await PausedTrial(plan, pictures=full).begin()

    asyncio.run(looked())


EVERYBODY = [
    "flip?p=0.4", "flip?p=0.4&only=moved", "tremble?p=0.1", "drop?p=0.2", "delay?lag=2",
    "correction?p=0.4", "nudge", "remark", "distract?p=0.3",
    "warn?rate=0.4", "flip?p=0.4 + nudge",
]  # fmt: skip
NOBODY = ["history?last=2", "hypothesis", "nudge + history?last=0"]


def check(condition, by):
    check_playable([read_condition(condition)], by)


@pytest.mark.parametrize("by", [PERSON, CLIENT], ids=["person", "client"])
def test_what_is_told_done_or_said_can_be_played(by):
    for condition in EVERYBODY:
        check(condition, by)
    check_playable(study("why", agent=["random"]).conditions, by)


@pytest.mark.parametrize(("by", "why"), [(PERSON, "a person remembers what they saw"), (CLIENT, "a client keeps")])
@pytest.mark.parametrize("condition", NOBODY)
def test_what_is_remembered_or_asked_for_cannot(condition, by, why):
    named = condition.removeprefix("nudge + ").partition("?")[0]
    with pytest.raises(BadValue, match=f"condition: got '{named}.*expected what is told or done, or nudge.*{why}"):
        check(condition, by)


def test_who_reads_words_alone_is_asked_for_nothing_else():
    async def decides(briefing, **settings):
        held = await PausedTrial(PLAN, **settings).begin()
        asked = replace(held.situation, briefing=briefing)
        held._said.put_nowait(None)
        try:
            return await held.decide(asked, None)
        finally:
            await held.close()

    words = Briefing(remark="Look.", warning="Mind.")
    asked = replace(words, instruction="{joints}")
    for briefing, settings in ((words, {"words_alone": True}), (asked, {})):
        asyncio.run(decides(briefing, **settings))
    with pytest.raises(ChannelFault, match="more than a remark or a warning"):
        asyncio.run(decides(asked, words_alone=True))
