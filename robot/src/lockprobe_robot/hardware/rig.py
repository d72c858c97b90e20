"""A rig: arm, operator and source of the truth in front of a real box, as a plant (paper, Sec. 2.1).

The sequence of an attempt is: home, picture, guarded move, verdict, picture. The verdict is the robot's judgement. The
truth comes from a sight (pictures) or the operator. Without either, the verdict replaces the truth, and the record says
so.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Literal

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.foundation.errors import LockprobeError, PlantFault
from lockprobe.plants.manual import Manual, Operator, ask_to_begin
from lockprobe.trial.record import Fact, Snapshot
from lockprobe_robot.arm.guarded_move import guarded_move
from lockprobe_robot.box_model.panel import PanelLayout
from lockprobe_robot.hardware.bounds import Bounded
from lockprobe_robot.hardware.sight import Sight, only_moved


class Rig(Manual):
    """A box whose joints an arm moves, and a source of the truth, as a plant.

    A fault of any part first stops the arm and then ends the trial as an error of the plant, which is owed again.

    Args:
        panel: The board, with its pose in the frame of the arm's base.
        operator: Sets up the box, agrees to motions, and tells the truth if ``truth`` is ``person``.
        truth: ``person``; a sight, which reads it; or ``verdict``: the robot's verdict stands in for it.
        rung: How real the rig is; the record says it.
        facts: Further facts for the record: calibration, versions, serial numbers.
    """

    attended = True

    def __init__(
        self,
        box: Lockbox,
        *,
        labels: tuple[str, ...],
        arm: Bounded,
        panel: PanelLayout,
        operator: Operator,
        truth: Sight | Literal["person", "verdict"] = "person",
        rung: str = "robot",
        facts: Mapping[str, Fact] | None = None,
    ) -> None:
        super().__init__(box, labels=labels, operator=operator)
        self.box, self.arm, self.panel, self._rung, self._facts = box, arm, panel, rung, dict(facts or {})
        self._sight = None if isinstance(truth, str) else truth
        self._truth = truth if isinstance(truth, str) else str(truth.facts.get("truth", "camera"))

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Rung, source of the truth, limits, camera, further facts, stops and late commands so far."""
        return {
            "rung": self._rung,
            "truth": self._truth,
            **self.arm.facts,
            **(self._sight.facts if self._sight is not None else {}),
            **self._facts,
            "stops": self.arm.stops,
            "late_commands": self.arm.late,
        }

    def observe(self) -> Snapshot:
        """The truth now; before the first attempt the operator sets the box up and the arm goes home.

        Raises:
            PlantFault: If any part fails.
            UserMistake: If the operator stops before the trial begins.
        """
        with self._stopping():
            return super().observe()

    def attempt(self, joint: int) -> Snapshot:
        """Attempt a joint, by index in panel order.

        Raises:
            PlantFault: If any part fails, or another joint moves.
        """
        before = self._configuration
        assert before is not None
        path = self.panel.handle_path(joint, before[joint])
        with self._stopping():
            touch = guarded_move(self.arm, path)
            called, moved = self._called[joint], touch.verdict == "moved"
            if (seen := self._seen()) is None and self._truth == "person":
                moved = self._operator.ask(f"Did joint {called} move? y/n, q to stop:", ("y", "n")) == "y"
            elif seen is None and touch.verdict == "failed":
                raise PlantFault(f"{called}: the robot's verdict is failed, and nothing else tells the truth")
            by_verdict = tuple(at != (moved and i == joint) for i, at in enumerate(before))
            after = self._configuration = only_moved(self._called, joint, before, seen or by_verdict)
        return Snapshot(
            configuration=after,
            joint=joint,
            outcome="moved" if after[joint] != before[joint] else "blocked",
            sensed={**touch.as_facts(), "truth": self._truth},
            look=self._look,
        )

    def close(self) -> None:
        """Stop the arm, and release the camera and the log."""
        self.arm.close()
        if self._sight is not None:
            self._sight.close()

    @contextmanager
    def _stopping(self) -> Iterator[None]:
        """What fails within it stops the arm."""
        try:
            yield
        except LockprobeError:
            self.arm.stop()
            raise

    def _begin(self) -> None:
        while True:
            ask_to_begin(self._operator)
            self.arm.home()
            if (seen := self._seen()) in (None, self.box.initial):
                return
            self._operator.tell(f"The {self._truth} sees {bits(seen or ())}, expected {bits(self.box.initial)}.")

    def _seen(self) -> Configuration | None:
        """The configuration that the sight reads now; None without one."""
        if self._sight is None:
            return None
        seen = self._sight.read(self._called)
        self._look = seen.look
        return seen.configuration
