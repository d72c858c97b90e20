"""People for tests who see scenes and nothing else: strategies that decide from what a page would show."""

import asyncio
import base64
from collections.abc import Mapping
from contextlib import asynccontextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from builders import study_of

from lockprobe.agents.catalogue import resolve
from lockprobe.interventions.conditions import read_condition
from lockprobe.people.assignment import conditions_of
from lockprobe.people.diary import Act, Agree, Answers, Attempt, read_diaries
from lockprobe.people.experiment import Experiment, read_words
from lockprobe.people.scenes import ActRefused
from lockprobe.people.server_state import Reply, ServerState
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.studies.study import Study
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Decision, Percept, Situation, Task, Turn

WORDS = read_words("en")
GO_ON = Answers(answers=(), rt=1.0)


def people_study(**settings) -> Study:
    """A small study that people play."""
    usual = {"name": "flips", "agents": ("participant",), "repetitions": 1, "trials": 4, "max_steps": 12, "seed": 7}
    return study_of(**usual | settings)


def under(*specs: str, **settings) -> Study:
    """The same under any conditions."""
    return replace(people_study(**settings), conditions=tuple(map(read_condition, specs)))


def short(**settings) -> Experiment:
    """An experiment without practice and without questions on the instructions."""
    return Experiment(**{"practice": "", "comprehension": False, **settings})


class Parts(dict):
    """A part of a scene: what it says has the name that the page reads."""

    __getattr__ = dict.__getitem__


def parts(value):
    """What is in a scene, by names."""
    if isinstance(value, list | tuple):
        return tuple(map(parts, value))
    return Parts({name: parts(one) for name, one in value.items()}) if isinstance(value, dict) else value


class Reception:
    """The server without HTTP, as pages see it: it is asked as the server is, and parts of its scenes have names."""

    def __init__(self, state: ServerState) -> None:
        self.state = state
        self.opened = state._opened

    def __getattr__(self, name: str):
        async def asked(*given) -> Reply:
            reply = await getattr(self.state, name)(*given)
            return reply._replace(scene=parts(reply.scene))

        return asked

    @property
    def sessions(self):
        """Of everybody who takes part."""
        return tuple(self.state._people)


def free(reception: Reception) -> list[int]:
    """How many trials of each condition are left."""
    study = reception.opened.scenes.study
    taken = {
        (slot.condition, slot.repetition, slot.trial) for one in reception.sessions for slot in one.diary.slots_kept
    }
    trials = reception.opened.journal.trials.values()
    taken |= {(one.condition, one.repetition, one.trial) for one in trials if one.player and not one.owed_again}
    return [study.repetitions * study.trials - sum(of == one for of, *_ in taken) for one in conditions_of(study)]


class Clock:
    """Seconds since 1970 that pass when they are told to."""

    def __init__(self) -> None:
        self.now = 1_790_000_000.0

    def __call__(self) -> float:
        self.now += 0.5
        return self.now


class Player:
    """A strategy at a page. It knows the scenes that it was shown, and which luck its box has, for its own draws."""

    def __init__(self, directory: Path, study: Study, spec: str) -> None:
        self._directory, self._study, self._agent = directory, study, resolve(spec).make()
        self._past: tuple[Turn, ...] = ()
        self._streams = {}

    async def act(self, shown: Reply) -> Act:
        """What it does."""
        scene = shown.scene
        if scene.kind != "box":
            return an_act(scene)
        if scene.step == 1:
            self._past = ()
        joints = scene.panel.joints
        task = Task(
            joints=tuple(joint.label for joint in joints),
            target=next(joint.label for joint in joints if joint.target),
            budget=scene.budget,
            places=tuple(joint.place for joint in joints if joint.place),
            assessment=self._study.assessment,
        )
        situation = Situation(task=task, past=self._past, percept=percept_of(scene.panel))
        decision = await self._agent.decide(situation, self._stream(scene, shown.participant)(scene.step))
        self._past = (*self._past, Turn(percept=situation.percept, decision=decision))
        said = {"claimed": decision.claimed or "moved", "claimed_rt": 200.0} if scene.ask else {}
        return Attempt(joint=decision.joint, rt=412.5, **said)

    def _stream(self, scene: Parts, identity: str | None):
        """The random stream of the strategy in a box, looked up once; any stream in a preview, of which nothing is kept."""
        if (identity, scene.number) not in self._streams:
            known = [diary for diary in read_diaries(self._directory) if diary.identity == identity]
            if not known:
                return np.random.default_rng
            luck = known[0].plan(self._study, max(1, scene.number)).luck
            self._streams[identity, scene.number] = partial(luck.at, "agent" if scene.number else "practice")
        return self._streams[identity, scene.number]


def an_act(scene: Parts) -> Act:
    """What anybody does in a scene: the first answer, the right ones on the instructions, one joint after the other."""
    match scene.kind:
        case "consent":
            return Agree(agreed=True)
        case "box":
            label, said = scene.panel.joints[scene.step % 2].label, {"claimed": "moved"} if scene.ask else {}
            return Attempt(joint=label, rt=1.0, **said)
        case "comprehension":
            known = {one.question: one.right for one in WORDS.comprehension.questions}
            return Answers(answers=tuple(known[one.question] for one in scene.questions), rt=640.5)
        case "check" | "ask":
            return Answers(answers=((*scene.questions[0].options, "")[0],), rt=812.5)
    return GO_ON


def percept_of(panel: Parts) -> Percept:
    """What is told on a panel, as agents have it."""
    pictures = tuple(
        Picture(kind=kind, png=base64.b64decode(url.partition(",")[2]))
        for kind, url in zip(("rgb", "depth"), panel.pictures, strict=False)
    )
    positions = tuple(joint.position == 1 for joint in panel.joints if joint.position is not None)
    return Percept(
        joint=panel.last, outcome=panel.outcome, positions=positions or None, text=" ".join(panel.report), pictures=pictures,
    )  # fmt: skip


async def go_on(reception: Reception, player: Player, shown: Reply, until=lambda shown: False) -> Reply:
    """Act until the end, or until something is shown."""
    while shown.scene.kind not in ("debrief", "closed") and not until(shown):
        act = await player.act(shown)
        shown = await reception.act(shown.token, shown.turn, act, {})
    return shown


def take_part(
    directory: Path,
    study: Study,
    experiment: Experiment,
    spec: str = "human-inspired",
    people: int = 1,
    *,
    platform: Mapping[str, str] | None = None,
    until=lambda shown: False,
    clock=None,
) -> list[Reply]:
    """So many people take part side by side, until the end or until something is shown; what they are shown last."""

    async def one(reception: Reception) -> Reply:
        shown = await reception.enter(None, platform or {})
        act = Agree(agreed=True)
        if until(shown) or shown.scene.kind != "consent":
            return shown
        shown = await reception.act(shown.token, shown.turn, act, platform or {})
        return await go_on(reception, Player(directory, study, spec), shown, until)

    async def all_of_them() -> list[Reply]:
        async with opened(directory, study, experiment, clock=clock) as reception:
            return await asyncio.gather(*(one(reception) for _ in range(people)))

    return asyncio.run(all_of_them())


@asynccontextmanager
async def opened(directory: Path, study: Study, experiment: Experiment, *, clock=None, words=WORDS, page="1"):
    """The reception of a study."""
    async with ServerState.open(directory, study, experiment, words, clock=clock or Clock(), page=page) as state:
        yield Reception(state)


def diary_of(directory: Path, identity: str):
    """What is written of somebody."""
    return next([one.joined, *one.lines] for one in read_diaries(directory) if one.identity == identity)


def without_page(study: Study, trial, spec: str):
    """The same trial as a strategy plays it without a page."""
    plan = study.plan(trial.agent, study.labelled(trial.condition), trial.repetition, trial.trial)
    return asyncio.run(play_timed(plan, resolve(spec).make()))[0]


def as_played(trial, *, claims: bool = True):
    """The steps of a trial, decisions as far as a page sends them."""
    return [
        (step.step, step.state, step.joint, step.moved, step.told_moved, step.told_state, step.told, step.pictures,
         Decision(joint=step.decision.joint, claimed=step.decision.claimed if claims else None))
        for step in trial.steps
    ]  # fmt: skip


def sitting(directory: Path, study: Study, body, *, experiment: Experiment | None = None):
    """Somebody has agreed to take part; ``body`` is played with the reception and what they are shown."""

    async def played():
        async with opened(directory, study, experiment or short()) as reception:
            shown = await reception.enter(None, {})
            shown = await reception.act(shown.token, 1, Agree(agreed=True), {})
            return await body(reception, shown)

    return asyncio.run(played())


async def to_first(kind: str, reception: Reception, shown: Reply) -> Reply:
    """Go on, with any joint, to the first scene of a kind."""
    while shown.scene.kind != kind:
        shown = await reception.act(shown.token, shown.turn, an_act(shown.scene), {})
    return shown


async def refused(reception: Reception, shown: Reply, act: Act) -> str:
    """The code with which an act is refused in the scene that is shown."""
    with pytest.raises(ActRefused) as refusal:
        await reception.act(shown.token, shown.turn, act, {})
    return refusal.value.code
