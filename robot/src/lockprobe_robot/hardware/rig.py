"""A rig: arm, camera and operator in front of a real box, as a plant (paper, Sec. 2.1).

The sequence of an attempt is: home, picture, guarded move, verdict, picture. The verdict is the robot's judgement. The
truth comes from the camera or the operator. Without either, the verdict replaces the truth, and the record says so.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.foundation.errors import LockprobeError, PlantFault
from lockprobe.plants.operator import Operator, ask_to_begin
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.record import Fact, Snapshot
from lockprobe_robot.arm.guarded_move import GuardedMove, HandlePath, TouchVerdict
from lockprobe_robot.hardware.board import Board
from lockprobe_robot.hardware.bounds import Bounded
from lockprobe_robot.hardware.camera import HardwareCamera, Shot, check_shot
from lockprobe_robot.hardware.driver_call import call_driver
from lockprobe_robot.hardware.dry_run import HEIGHT, DryMotion, DryRun, check_height, run_dry
from lockprobe_robot.hardware.position_reader import ImageHandles, Unclear, read_positions

Rung = Literal["scripted", "twin", "dry-run", "robot"]
"""How real the rig is; the record says which."""

TruthFrom = Literal["camera", "person", "simulation", "verdict"]
"""Where the truth comes from. ``verdict``: there is none, and the robot's verdict stands in for it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Eye:
    """A fixed camera that sees the box while the arm is at home.

    Attributes:
        camera: The camera.
        handles: The places of the handles in its pictures.
    """

    camera: HardwareCamera
    handles: ImageHandles


class Rig:
    """A box, an arm, and a source of the truth, as a plant.

    A fault of any part first stops the arm and then ends the trial as an error of the plant, which is owed again.

    Args:
        box: The box.
        labels: Labels of the joints, in panel order.
        arm: The arm within its bounds.
        board: The board, whose pose in the frame of the arm's base is known.
        path: Instead of the board, a function from joint (index in panel order) and present position to the handle's
            path in that frame.
        operator: Sets up the box, agrees to motions, and tells the truth if ``truth`` is ``person``.
        eye: A camera, for pictures and, if ``truth`` is ``camera``, for the truth.
        truth: Source of the truth.
        rung: Realism of the rig (the rung of a rehearsal, or ``robot``).
        move: Parameters of the guarded move.
        facts: Further facts for the record: versions, serial numbers, calibration.
        state: The true configuration, if ``truth`` is ``simulation``.
        release: Called when the rig is closed, after the arm was stopped.
    """

    attended = True

    def __init__(
        self,
        box: Lockbox,
        *,
        labels: tuple[str, ...],
        arm: Bounded,
        operator: Operator,
        board: Board | None = None,
        path: Callable[[int, bool], HandlePath] | None = None,
        eye: Eye | None = None,
        truth: TruthFrom = "person",
        rung: Rung = "robot",
        move: GuardedMove | None = None,
        facts: Mapping[str, Fact] | None = None,
        state: Callable[[], Configuration] | None = None,
        release: Callable[[], None] = lambda: None,
    ) -> None:
        assert truth != "camera" or eye is not None
        assert (truth == "simulation") == (state is not None)
        if path is None:
            assert board is not None
            path = board.panel.handle_path
        self._state, self._release = state, release
        self._box, self._arm, self._path, self._operator, self._eye = box, arm, path, operator, eye
        self._truth, self._rung, self._move, self._more = truth, rung, move or GuardedMove(), dict(facts or {})
        self._board_facts = dict(board.facts if board is not None else {})
        self._called = tuple(f"{label} ({name})" for label, name in zip(labels, box.names, strict=True))
        self._configuration: Configuration | None = None
        self._shot: Shot | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Rung, source of the truth, limits, camera, the board's calibration, stops and late commands so far."""
        counted: dict[str, Fact] = {"stops": self._arm.stops, "late_commands": self._arm.late}
        return {
            "rung": self._rung,
            "truth": self._truth,
            **self._arm.facts,
            **self._board_facts,
            **(getattr(self._eye.camera, "facts", {}) if self._eye is not None else {}),
            **self._more,
            **counted,
        }

    def observe(self) -> Snapshot:
        """The truth now; before the first attempt the operator sets the box up and the arm goes home.

        Raises:
            PlantFault: If any part fails.
            UserMistake: If the operator stops before the trial begins.
        """
        if self._configuration is None:
            try:
                self._begin()
            except LockprobeError:
                self._arm.stop()
                raise
        assert self._configuration is not None
        return Snapshot(configuration=self._configuration, look=self._look())

    def attempt(self, joint: int) -> Snapshot:
        """Attempt a joint, by index in panel order.

        Raises:
            PlantFault: If any part fails, or another joint moves.
        """
        before = self._configuration
        assert before is not None
        try:
            touch = self._move.attempt(self._arm, self._path(joint, before[joint]))
            after = self._after(joint, before, touch.verdict)
            self._only(joint, before, after)
        except LockprobeError:
            self._arm.stop()
            raise
        self._configuration = after
        moved = after[joint] != before[joint]
        return Snapshot(
            configuration=after,
            joint=joint,
            outcome="moved" if moved else "blocked",
            sensed={**touch.as_facts(), "truth": self._truth},
            look=self._look(),
        )

    def dry_run(self, height: float = HEIGHT, tell: Callable[[DryMotion], None] = lambda made: None) -> DryRun:
        """Make every joint's motion above the board, in both directions, and touch nothing. No trial begins.

        The operator has to agree before the first motion.

        Args:
            height: Height above the handles, metres, [0.05, 0.3].
            tell: Called after every motion.

        Raises:
            BadValue: If the height is out of range.
            PlantFault: If any part fails, the hand sinks, or it feels a contact; the arm is stopped first.
        """
        check_height(height)
        self._operator.tell(f"Dry run: the hand stays {1000 * height:g} mm above the handles and touches nothing.")
        ways = {name: (self._path(joint, False), self._path(joint, True)) for joint, name in enumerate(self._box.names)}
        try:
            motions = run_dry(self._arm, ways, height=height, move=self._move, tell=tell)
        except LockprobeError:
            self._arm.stop()
            raise
        return DryRun(box=self._box.name, height=height, motions=motions, facts=self.facts)

    def close(self) -> None:
        """Stop the arm, and release the camera and the log."""
        self._arm.stop()
        self._arm.log.close()
        release = getattr(self._eye.camera, "close", None) if self._eye is not None else None
        if release is not None:
            call_driver("the camera", release)
        self._release()

    def _begin(self) -> None:
        initial = self._box.initial
        stand = ", ".join(f"{called} at {at:d}" for called, at in zip(self._called, initial, strict=True))
        self._operator.tell(f"New trial of {self._box.name}. Set the joints: {stand}.")
        while True:
            ask_to_begin(self._operator)
            self._arm.home()
            self._photograph()
            if self._truth != "camera" or (seen := self._seen()) == initial:
                break
            self._operator.tell(f"The camera sees {bits(seen)}, expected {bits(initial)}.")
        self._configuration = initial

    def _after(self, joint: int, before: Configuration, verdict: TouchVerdict) -> Configuration:
        """The configuration after an attempt, from the source of the truth."""
        self._photograph()
        if self._truth == "camera":
            return self._seen()
        if self._state is not None:
            return call_driver("the simulation", self._state)
        if self._truth == "person":
            moved = self._operator.ask(f"Did joint {self._called[joint]} move? y/n, q to stop:", ("y", "n")) == "y"
        elif verdict == "failed":
            raise PlantFault(f"{self._called[joint]}: the robot's verdict is failed, and nothing else tells the truth")
        else:
            moved = verdict == "moved"
        return tuple(at != (moved and i == joint) for i, at in enumerate(before))

    def _only(self, joint: int, before: Configuration, after: Configuration) -> None:
        others = [i for i, (was, now) in enumerate(zip(before, after, strict=True)) if was != now and i != joint]
        if others:
            moved = ", ".join(self._called[i] for i in others)
            states = f"{bits(before)} became {bits(after)}"
            raise PlantFault(f"{self._called[joint]} was attempted and {moved} moved: {states}")

    def _photograph(self) -> None:
        if (eye := self._eye) is not None:
            self._shot = check_shot(call_driver("the camera", eye.camera.grab), eye.handles.size)

    def _seen(self) -> Configuration:
        assert self._eye is not None
        assert self._shot is not None
        try:
            return read_positions(self._shot, self._eye.handles.places, self._called)
        except Unclear as unclear:
            raise PlantFault(str(unclear)) from None

    def _look(self) -> Callable[[], Frame] | None:
        if self._eye is None or self._shot is None:
            return None
        frame = self._eye.handles.frame(self._shot)
        return lambda: replace(frame)
