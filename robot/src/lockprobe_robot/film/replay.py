"""Makes a film of a trial: its recorded actions are played again with the same luck.

The trial's plant is built again from its spec and its stream. A trial on a plant without physics is played by the arm
of a twin of the same box. Each step is compared with the record.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Lockbox, bits
from lockprobe.foundation.errors import BadFile, BadValue, TrialFault
from lockprobe.plants.catalogue import PlantSource, resolve_plant
from lockprobe.studies.study import Study
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.protocols import Plant
from lockprobe.trial.record import Fact, Snapshot, Trial
from lockprobe_robot.film.caption import WIDTH, CaptionLine, captioned, opening_lines, outcome_lines
from lockprobe_robot.film.files import RATES, FilmFile, open_film
from lockprobe_robot.filming import BOARD, FILM_CAMERA

if TYPE_CHECKING:
    from lockprobe_robot.rendering.opengl import OpenGL

STAND_IN, WITHOUT_ARM = "twin", "fast-twin"
"""The plant on which a trial of a plant without a camera is filmed, and that of a box that the arm does not reach."""

FASTEST = 16

_HOOK_RATE = 25.0
"""Pictures per simulated second that a twin offers."""

_HEIGHT = 420
_LAMP = np.array([0.0, 1.0, 1.5])
"""Where the lamp of a film is, metres: on the side of its camera, so that the arm is lit and shadows fall behind."""

_SHADOWS = 2.5
"""How far from it shadows are drawn, metres: farther, they are coarse."""

_HOLD = 1.2
"""Seconds that an outcome stays on screen."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Film:
    """A finished film.

    Attributes:
        path: The file, or the directory of pictures.
        pictures: Number of pictures.
        plant: Spec of the plant.
        differs: The first difference of the replay from the record, in one line; None without a difference.
        note: What the film shows in the place of the trial's plant, in one sentence; empty if it is that plant.
    """

    path: Path
    pictures: int
    plant: str
    differs: str | None
    note: str = ""


def plan_of(study: Study, trial: Trial) -> Plan:
    """The plan of a recorded trial.

    Raises:
        BadFile: If the study's settings have no such trial.
    """
    for plan in study.plans(trial.agent):
        if plan.key == trial.key:
            if (plan.box.names, Names(plan).labels) != (trial.joints, trial.labels):
                break
            return plan
    raise BadFile("study.json", f"its settings do not describe the trial {trial.key}")


def film_trial(
    trial: Trial, plan: Plan, path: Path, *, speed: int = 5, tell: Callable[[str], None] = lambda said: None
) -> Film:
    """Play a recorded trial again and film it.

    Args:
        trial: The record.
        plan: Its plan.
        path: The film: ``.gif``, ``.mp4``, or a directory for the pictures.
        speed: Speed-up of a twin's motion, a factor of 1 to 16.
        tell: Called with one line after every step.

    Raises:
        UserMistake: If the trial cannot be filmed here.
        PlantFault: If the plant breaks and the record holds no error of the plant.
    """
    if not 1 <= speed <= FASTEST:
        raise BadValue("speed", speed, f"a whole number from 1 to {FASTEST}")
    source = resolve_plant(plan.plant)
    if source.picture_size is None and source.make_filmed is None:
        source = _stand_in(plan.box)
    source.check(plan.box)
    file = open_film(path)
    runs = source.make_filmed is not None
    recorder = _FilmRecorder(file, runs=runs, rate=RATES[path.suffix.lower()], speed=speed)
    try:
        differs = _play_again(trial, plan, source, recorder, tell)
    finally:
        recorder.close()
        file.close()
    return Film(path=path, pictures=recorder.pictures, plant=source.spec, differs=differs)


def _stand_in(box: Lockbox) -> PlantSource:
    source = resolve_plant(STAND_IN)
    try:
        source.check(box)
    except BadValue:  # its handles are out of the arm's reach
        return resolve_plant(WITHOUT_ARM)
    return source


def _play_again(
    trial: Trial, plan: Plan, source: PlantSource, recorder: _FilmRecorder, tell: Callable[[str], None]
) -> str | None:
    plant = _plant(plan, source, recorder)
    differs: str | None = None
    try:
        snapshot = plant.observe()
        recorder.show(snapshot, opening_lines(trial), _HOLD)
        for at, step in enumerate(trial.steps):
            before = bits(snapshot.configuration)
            lines = outcome_lines(trial, at)
            recorder.begin(snapshot, lines)
            snapshot = plant.attempt(trial.joints.index(step.joint))
            recorder.show(snapshot, lines, _HOLD)
            differs = differs or difference(trial, at, before, snapshot)
            tell(f"step {at + 1} of {len(trial.steps)}, {recorder.pictures} pictures")
    except TrialFault as fault:
        if trial.error is None or trial.error.boundary != fault.boundary:
            raise
        tell(f"it breaks as it did then: {fault}")
    finally:
        plant.close()
    return differs


def _plant(plan: Plan, source: PlantSource, recorder: _FilmRecorder) -> Plant:
    labels, rng = Names(plan).labels, plan.luck.physics()
    if source.make_filmed is None:
        return source.make(plan.box, labels, rng)
    return source.make_filmed(plan.box, labels, rng, recorder)


def difference(trial: Trial, at: int, before: str, snapshot: Snapshot) -> str | None:
    """The first difference between a replayed step and its record, in one line."""
    step = trial.steps[at]
    pairs: list[tuple[str, Fact, Fact]] = [
        ("configuration before it", step.state, before),
        ("outcome", "moved" if step.moved else "blocked", snapshot.outcome),
    ]
    if "verdict" in step.sensed and "verdict" in snapshot.sensed:
        pairs.append(("robot's verdict", step.sensed["verdict"], snapshot.sensed["verdict"]))
    for what, recorded, replayed in pairs:
        if recorded != replayed:
            return f"step {at + 1} differs from the record: {what} {recorded} there, {replayed} here"
    return None


class _FilmRecorder:
    """Records pictures of a plant: at regular intervals while a twin runs, and single pictures on request."""

    def __init__(self, file: FilmFile, *, runs: bool, rate: float, speed: int) -> None:
        self.pictures = 0
        self._runs = runs
        self._file = file
        self._seconds = 1 / rate
        self._every = max(1, round(_HOOK_RATE * speed / rate))
        self._corner = f"{speed}x" if speed > 1 and runs else ""
        self._calls = 0
        self._lines: tuple[CaptionLine, ...] | None = None
        self._renderer: OpenGL | None = None
        self._running: tuple[Any, Any] | None = None

    def __call__(self, model: Any, data: Any) -> None:
        """Take a picture of a running simulation; called 25 times per simulated second, first when it is made."""
        self._running = model, data
        self._calls += 1
        if self._lines is not None and self._calls % self._every == 0:
            self._add(self._oblique(), self._lines, self._seconds)

    def begin(self, snapshot: Snapshot, lines: tuple[CaptionLine, ...]) -> None:
        """Set the caption of the next pictures; a plant that does not run is shown now."""
        self._lines = lines
        if not self._runs:
            self.show(snapshot, lines, _HOLD / 2)

    def show(self, snapshot: Snapshot, lines: tuple[CaptionLine, ...], seconds: float) -> None:
        """Hold the plant's present state for some seconds."""
        if self._running is not None:
            self._add(self._oblique(), lines, seconds)
        elif snapshot.look is not None:
            self._add(snapshot.look().rgb, lines, seconds)

    def close(self) -> None:
        """Release the renderer."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def _oblique(self) -> NDArray[np.uint8]:
        """The running twin at this moment."""
        assert self._running is not None
        model, data = self._running
        if self._renderer is None:
            from lockprobe_robot.rendering.probe import open_renderer

            lit, lamp = copy.copy(model), model.light("lamp").id
            lit.light_pos[lamp], lit.light_dir[lamp] = _LAMP, (BOARD - _LAMP) / np.linalg.norm(BOARD - _LAMP)
            lit.vis.map.shadowclip = _SHADOWS
            self._renderer = open_renderer(lit, width=WIDTH, height=_HEIGHT)
        return self._renderer.colours(data, FILM_CAMERA)

    def _add(self, picture: NDArray[np.uint8], lines: tuple[CaptionLine, ...], seconds: float) -> None:
        self._file.add(captioned(picture, lines, self._corner), seconds)
        self.pictures += 1
