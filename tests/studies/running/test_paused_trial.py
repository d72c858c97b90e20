"""A trial waits at each decision, and goes on after it was let go of."""

import asyncio
from dataclasses import replace

import pytest
from seated import as_played, people_study, without_page
from seen import PhotographedPlant

from lockprobe.agents.outside import participant_spec
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.interventions.conditions import flips
from lockprobe.plants import catalogue
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.running.paused_trial import PausedTrial, RecordedAttempt

STUDY = people_study(layout="shuffled")
PLAN = STUDY.plan(participant_spec("3f9a01bc"), STUDY.labelled("flip?p=0.4"), 1, 2)


def steps_of(trial):
    """A trial as its steps are on disk."""
    labels = dict(zip(trial.joints, trial.labels, strict=True))
    return [RecordedAttempt(labels[step.joint], step.decision.claimed, step.told) for step in trial.steps]


@pytest.fixture(scope="module")
def alone():
    blank = asyncio.run(_blank())
    return without_page(STUDY, blank, "human-inspired")


async def _blank():
    held = await PausedTrial.begin(PLAN)
    for _ in range(PLAN.budget):
        if held.trial is None:
            await held.attempt(held.situation.task.joints[0])
    return held.trial


def test_it_goes_on_after_every_step(alone):
    played = steps_of(alone)

    async def each() -> None:
        for number in range(len(played) + 1):
            held = await PausedTrial.begin(PLAN, played[:number])
            told = [await held.attempt(step.joint, step.claimed) for step in played[number:]]
            assert told == [step.told for step in played[number:]]
            assert held.situation is None
            assert as_played(held.trial) == as_played(alone)
            await held.close()

    asyncio.run(each())


@pytest.mark.parametrize(
    "wrong", [{"told": "A moved. At 1: none."}, {"joint": "Z"}], ids=["another report", "no such joint"]
)
def test_another_history_is_never_shown(alone, wrong):
    played = steps_of(alone)
    said = {"joint": played[1].joint, "claimed": played[1].claimed, "told": played[1].told}
    with pytest.raises(BadValue, match=r"step 2 of flips/participant/flip\?p=0\.4/rep=1/trial=2"):
        asyncio.run(PausedTrial.begin(PLAN, [played[0], RecordedAttempt(**(said | wrong)), *played[2:4]]))


class _Counted(SymbolicPlant):
    """Counts how often it was let go of, and breaks when it is told to."""

    closed = 0
    breaks_at = 99

    def __init__(self, box):
        super().__init__(box)
        self._attempts = 0

    def observe(self):
        if self.breaks_at == 0:
            raise OSError("no light")
        return super().observe()

    def attempt(self, joint):
        self._attempts += 1
        if self._attempts == self.breaks_at:
            raise OSError("stuck")
        return super().attempt(joint)

    def close(self):
        type(self).closed += 1


@pytest.fixture
def plant(monkeypatch):
    class Plant(_Counted):
        pass

    source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: Plant(box))
    monkeypatch.setattr("lockprobe.plants.catalogue.resolve_plant", lambda spec: source)
    return Plant


@pytest.mark.parametrize("breaks_at", [0, 2])
def test_what_breaks_ends_it_as_an_error(plant, breaks_at):
    plant.breaks_at = breaks_at

    async def broken():
        held = await PausedTrial.begin(PLAN)
        for _ in range(breaks_at):
            told = await held.attempt("A")
        assert held.situation is None
        assert not held.sound
        assert breaks_at == 0 or told == ""
        await held.close()
        return held.trial

    trial = asyncio.run(broken())
    assert (trial.ending, trial.error.boundary, len(trial.steps)) == ("error", "plant", max(0, breaks_at - 1))
    assert plant.closed == 1


def test_pictures_are_kept_and_are_no_words(tmp_path, monkeypatch):
    source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: PhotographedPlant(box))
    monkeypatch.setattr("lockprobe.plants.catalogue.resolve_plant", lambda spec: source)
    plan = replace(PLAN, condition=flips((0.0,), modalities=("rgb",))[0])

    async def looked() -> None:
        held = await PausedTrial.begin(plan, pictures=tmp_path)
        told = [await held.attempt("A") for _ in range(2)]
        assert told == ["", ""]
        names = [picture.name for picture in held.situation.percept.pictures]
        assert set(names) <= {path.name for path in tmp_path.iterdir()}
        await held.close()
        full = tmp_path / "file"
        full.write_text("")
        with pytest.raises(BadFile):
            await PausedTrial.begin(plan, pictures=full)

    asyncio.run(looked())
