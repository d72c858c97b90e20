"""``lockprobe replay --out``: a film of a trial of a study, whose recorded actions are played again with the same luck.

A trial on a plant without physics is played by the arm of a twin of the same box.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import bits
from lockprobe.foundation.errors import BadFile, BadValue, TrialFault
from lockprobe.foundation.spec import Spec
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.study import Study
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Plant
from lockprobe.trial.record import Fact, Snapshot, Trial
from lockprobe_robot.film.caption import WIDTH, CaptionLine, captioned, opening_lines, outcome_lines
from lockprobe_robot.film.files import FilmFile
from lockprobe_robot.renderer import Renderer

STAND_IN, WITHOUT_ARM = "twin", "fast-twin"
"""The plant on which a trial of a plant without a camera is filmed, and that of a box that the arm does not reach."""

_HOOK_RATE, _RATE = 25.0, 12.5
"""Pictures per simulated second that a twin offers, and per second of the film."""

_SPEED = 5
"""How many times as fast as it was a robot's motion is played."""

_HEIGHT = 420

_CAMERA = "oblique"
"""The camera of films in ``scene.xml``."""

_BOARD = np.array([0.42, 0.03, 0.16])
"""What it looks at, metres from the base of the arm."""

_LAMP = np.array([0.0, 1.0, 1.5])
"""Where the lamp of a film is, metres: on the side of its camera, so that the arm is lit and shadows fall behind."""

_SHADOWS = 1.2
"""How far from it shadows are drawn, metres: farther, they are coarse."""

_HOLD = 1.2
"""Seconds that an outcome stays on screen."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Film:
    """A finished film.

    Attributes:
        pictures: Number of pictures.
        differs: The first difference of the replay from the record, in one line; None without a difference.
        note: What the film shows in the place of the trial's plant, in one sentence; empty if it is that plant.
    """

    pictures: int
    differs: str | None
    note: str = ""


def make_film(directory: Path, trial: Trial, path: Path, *, tell: Callable[[str], None]) -> Film:
    """Film a trial of a study as a ``.gif``.

    ``tell`` is called with one line after every step that is played again.

    Raises:
        UserMistake: If the trial cannot be filmed here.
        TrialFault: If it breaks when it is played again, and did not then.
    """
    plan = plan_of(read_study(directory), trial)
    source, note = resolve_plant(plan.plant), ""
    if source.picture_size is None and source.make_filmed is None:
        source = resolve_plant(STAND_IN)
        try:
            source.check(plan.box)
        except BadValue:  # its handles are out of the arm's reach
            source = resolve_plant(WITHOUT_ARM)
        note = f"The plant {plan.plant} cannot be filmed: the film shows {source.spec} in its place."
    elif "model" in Spec.parse(source.spec, "plant").options:
        note = "A force pushed the model: the film shows it before and after each attempt."
    source.check(plan.box)
    file = FilmFile(path)
    differs: str | None = None
    recorder = _FilmRecorder(file)
    labels, rng = plan.names.labels, plan.luck.physics()
    try:
        if source.make_filmed is None:
            plant = source.make(plan.box, labels, rng)
        else:
            plant = source.make_filmed(plan.box, labels, rng, recorder)
        recorder.lines = opening_lines(trial)
        for at, snapshot, differs in played_again(trial, plant):  # noqa: B007
            recorder.show(snapshot.look, _HOLD)
            if at >= 0:
                tell(f"step {at + 1} of {len(trial.steps)}, {recorder.pictures} pictures")
            if at + 1 < len(trial.steps):
                recorder.lines = outcome_lines(trial, at + 1)
                if source.make_filmed is None:  # nothing shows the motion
                    recorder.show(snapshot.look, _HOLD / 2)
    finally:
        recorder.close()
        file.close()
    return Film(pictures=recorder.pictures, differs=differs, note=note)


def plan_of(study: Study, trial: Trial) -> Plan:
    """The plan of a recorded trial.

    Raises:
        BadFile: If the study's settings have no such trial.
    """
    for plan in study.plans(trial.agent):
        if plan.key == trial.key and (plan.box.names, plan.names.labels) == (trial.joints, trial.labels):
            return plan
    raise BadFile("study.json", f"its settings do not describe the trial {trial.key}")


def played_again(trial: Trial, plant: Plant) -> Iterator[tuple[int, Snapshot, str | None]]:
    """Play a recorded trial again on a plant, which is closed in the end.

    Yields:
        The step, from 0, or -1 for the beginning; what is seen after it; the first difference of what was played from
        the record, in one line, or None.

    Raises:
        TrialFault: If it breaks, and did not at the same boundary then.
    """
    differs: str | None = None
    try:
        snapshot = plant.observe()
        yield -1, snapshot, None
        for at, step in enumerate(trial.steps):
            before, snapshot = bits(snapshot.configuration), plant.attempt(trial.joints.index(step.joint))
            pairs: list[tuple[str, Fact, Fact]] = [
                ("configuration before it", step.state, before),
                ("outcome", "moved" if step.moved else "blocked", snapshot.outcome),
            ]
            if "verdict" in step.sensed and "verdict" in snapshot.sensed:
                pairs.append(("robot's verdict", step.sensed["verdict"], snapshot.sensed["verdict"]))
            for what, recorded, replayed in pairs:
                if recorded != replayed and differs is None:
                    differs = f"step {at + 1} differs from the record: {what} {recorded} there, {replayed} here"
            yield at, snapshot, differs
    except TrialFault as fault:
        if trial.error is None or trial.error.boundary != fault.boundary:
            raise
    finally:
        plant.close()


class _FilmRecorder:
    """Adds pictures of a plant to a film: at regular intervals while a twin runs, and single ones on request.

    Attributes:
        lines: The caption of the next pictures; no picture is taken before there is one.
        pictures: Number of pictures so far.
    """

    def __init__(self, file: FilmFile) -> None:
        self.lines: tuple[CaptionLine, ...] = ()
        self.pictures = 0
        self._file, self._calls = file, 0
        self._renderer: Renderer | None = None
        self._drawing = ThreadPoolExecutor(1)  # the arm of a rig moves in another thread than what looks at it
        self._running: tuple[mujoco.MjModel, mujoco.MjData] | None = None

    def __call__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Take a picture of a running simulation; called 25 times per simulated second, first when it is made."""
        self._running = model, data
        self._calls += 1
        if self.lines and self._calls % round(_HOOK_RATE * _SPEED / _RATE) == 0:
            self.show(None, 1 / _RATE)

    def show(self, look: Callable[[], Frame] | None, seconds: float) -> None:
        """Hold the present state of the simulation, or what is seen where none runs, for some seconds."""
        if self._running is not None:
            picture = self._drawing.submit(self._drawn, *self._running).result()
        elif look is not None:
            picture = look().rgb
        else:
            return
        corner = f"{_SPEED}x" if self._running is not None else ""
        self._file.add(captioned(picture, self.lines, corner), seconds)
        self.pictures += 1

    def close(self) -> None:
        """Release the renderer."""
        if self._renderer is not None:
            self._drawing.submit(self._renderer.close).result()
        self._drawing.shutdown()

    def _drawn(self, model: mujoco.MjModel, data: mujoco.MjData) -> NDArray[np.uint8]:
        if self._renderer is None:
            lit, lamp = copy.copy(model), model.light("lamp").id
            lit.light_pos[lamp], lit.light_dir[lamp] = _LAMP, (_BOARD - _LAMP) / np.linalg.norm(_BOARD - _LAMP)
            lit.vis.map.shadowclip = _SHADOWS
            self._renderer = Renderer(lit, width=WIDTH, height=_HEIGHT)
        self._renderer.pose(data)
        return self._renderer.colours(_CAMERA)
