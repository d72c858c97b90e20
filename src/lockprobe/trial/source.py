"""The source of reports: the truth, the verdict of an arm, or the positions that a camera reads.

The option ``source`` of ``symbolic`` names it (``symbolic?source=verdict``). It acts first: interventions act on what
it says, and the truth decides when the trial ends. If a source is named and the plant has a camera, a picture is taken
before the first attempt and after every attempt. The record holds its reading beside the arm's verdict and the truth.
Nothing is drawn from a random stream.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import Literal, get_args

from lockprobe.boxes.box import Configuration
from lockprobe.foundation.errors import PlantFault
from lockprobe.foundation.spec import Spec
from lockprobe.foundation.validation import check_choice
from lockprobe.trial.pictures.picture_reader import clear_positions
from lockprobe.trial.record import Fact, Snapshot, Trial

SourceKind = Literal["truth", "verdict", "camera"]
"""Where reports come from."""

VERDICT, CAMERA = "verdict", "camera"
"""The names in ``sensed`` of an arm's verdict, and of the positions that a camera reads, in panel order."""

UNCLEAR = "?"
"""In a reading: a joint whose position the picture does not show clearly; the others are 0 or 1."""


def said(source: SourceKind, truth: Snapshot, last: Snapshot | None) -> Snapshot:
    """What a source says in place of the truth, which holds what was sensed; ``last`` is what it said before.

    By the ``verdict`` of an arm the attempted joint moved if that is *moved*. After *blocked*, and after *failed* (no
    grip, or no conclusion), the robot has noticed no movement and says that the joint did not move. It knows how the
    box was set up and keeps count: the attempted joint changes its position if it moved, and all others stay where the
    robot last said they were. So a wrong verdict stays in its reports.

    Of the ``camera`` positions are those that it reads, and the attempted joint moved if its position changed. A joint
    that cannot be read clearly keeps its last position; at the first look that is the true one.
    """
    before = truth.configuration if last is None else last.configuration
    if source == "truth":
        return truth
    if source == "camera":
        if not is_reading(read := truth.sensed.get(CAMERA), len(before)):
            raise PlantFault(f"source=camera: the camera gave no reading of {len(before)} joints ({read!r})")
        now = _held(before, str(read))
    elif truth.joint is None:
        now = before
    elif (verdict := truth.sensed.get(VERDICT)) is None:
        raise PlantFault("source=verdict: the plant gave no verdict on the attempt")
    else:
        now = tuple(at != (i == truth.joint and verdict == "moved") for i, at in enumerate(before))
    if truth.joint is None:
        return replace(truth, configuration=now)
    moved = now[truth.joint] != before[truth.joint]
    return replace(truth, configuration=now, outcome="moved" if moved else "blocked")


@lru_cache(maxsize=256)
def source_of(modality: str) -> SourceKind | None:
    """The source that a modality names; None if it names none: then reports tell the truth, and no camera is read.

    >>> source_of("symbolic?source=verdict"), source_of("symbolic")
    ('verdict', None)
    """
    named = Spec.parse(modality, "modality").options.get("source")
    if named is not None:
        check_choice("source", named, get_args(SourceKind))
    return named  # type: ignore[return-value] # checked above


def with_reading(snapshot: Snapshot, recorded: Mapping[str, Fact]) -> Snapshot:
    """The snapshot with the camera's reading in ``sensed``, or with the recorded one; unchanged without a camera."""
    if CAMERA in recorded:
        return replace(snapshot, sensed={**snapshot.sensed, CAMERA: recorded[CAMERA]})
    if snapshot.look is None or CAMERA in snapshot.sensed:
        return snapshot
    frame = snapshot.look()
    read = clear_positions(frame.rgb, frame.camera.project(frame.handles)[..., :2])
    bits = "".join(UNCLEAR if one is None else str(int(one)) for one in read)
    return replace(snapshot, sensed={**snapshot.sensed, CAMERA: bits})


def is_reading(value: object, joints: int) -> bool:
    """Whether a value of ``sensed`` is a camera's reading of so many joints."""
    return isinstance(value, str) and len(value) == joints and set(value) <= {"0", "1", UNCLEAR}


def outcomes_by(source: str, trial: Trial) -> list[bool | None]:
    """For each step whether the attempted joint moved by the ``verdict`` of an arm, or by a ``camera``.

    None where the arm failed, the camera could not read that joint clearly after the attempt, or nothing was sensed.
    """
    if source == VERDICT:
        return [{"moved": True, "blocked": False}.get(str(step.sensed.get(VERDICT))) for step in trial.steps]
    unread = UNCLEAR * len(trial.joints)
    if not trial.steps:
        return []
    start, found = tuple(bit == "1" for bit in trial.steps[0].state), list[bool | None]()
    now = _held(start, str(trial.opening_sensed.get(CAMERA, unread)))
    for step in trial.steps:
        reading, place = str(step.sensed.get(CAMERA, unread)), trial.joints.index(step.joint)
        before, now = now, _held(now, reading)
        found.append(None if reading[place] == UNCLEAR else now[place] != before[place])
    return found


def _held(before: Configuration, reading: Sequence[str]) -> Configuration:
    """The positions of a reading; an unclear joint keeps the one before."""
    return tuple(at if read == UNCLEAR else read == "1" for at, read in zip(before, reading, strict=True))


def false_reports(trial: Trial) -> list[bool]:
    """Whether each report after which the trial went on was inverted.

    What an agent infers from two reports of positions is inverted if outcomes are. Where positions are inverted
    (``flip?inverts=position``), the earlier report may be false too; then the report itself counts: it is false if it
    shows the attempted joint in the wrong position.
    """
    if not (trial.states_only and any(channel.get("inverts") == "position" for channel in trial.channels)):
        return [step.told_falsely for step in trial.steps[:-1]]
    places = [trial.joints.index(step.joint) for step in trial.steps]
    return [
        step.told_state is not None and step.told_state[place] != after.state[place]
        for place, (step, after) in zip(places, pairwise(trial.steps), strict=False)
    ]
