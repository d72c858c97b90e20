"""Parts of a rig that break on request."""

import numpy as np
from drawn_board import HANDLES, HEIGHT, WIDTH, board
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.calibration.calibration_file import calibrated_board
from lockprobe_robot.hardware.bounds import Bounded, Bounds
from lockprobe_robot.hardware.rig import Rig
from lockprobe_robot.hardware.scripted_arm import ScriptedArm
from lockprobe_robot.hardware.sight import CameraSight, ImageHandles, Shot

from lockprobe.plants.manual import ENTER, OperatorStopped

SPACE = {"low": (-1.0, -1.0, -1.0), "high": (1.0, 1.0, 1.0)}


class Willing:
    """Agrees to everything, up to a number of questions; ``says`` are answers before that."""

    def __init__(self, *says, stops_after=10**6):
        self.says, self.questions, self.told, self.stops_after = list(says), [], [], stops_after

    def ask(self, question, answers):
        self.questions.append(question)
        if len(self.questions) > self.stops_after:
            raise OperatorStopped("the operator stopped")
        if self.says and self.says[0] in answers:
            return self.says.pop(0)
        return ENTER if ENTER in answers else "y"

    def tell(self, line):
        self.told.append(line)


class Breaking(ScriptedArm):
    """A scripted arm whose ``at``-th follow does something else. What it is told is in ``log``."""

    def __init__(self, box, path, *, at=10**9, instead=lambda arm: None):
        super().__init__(box, path)
        self.log, self._at_call, self._instead, self.calls = [], at, instead, 0

    def follow(self, position, velocity, *, stiffness):
        self.calls += 1
        if self.calls == self._at_call:
            self.log.append("broke")
            self._instead(self)
        super().follow(position, velocity, stiffness=stiffness)

    def stop(self):
        self.log.append("stop")


class DrawnCamera:
    """Draws the board as an arm's box stands; ``broken`` is called in place of a picture, if it is set."""

    broken = None

    def __init__(self, arm):
        self._arm, self.closed = arm, False

    def grab(self):
        if self.broken is not None:
            self.broken()
        return Shot(rgb=board(self._arm.configuration), depth=np.ones((HEIGHT, WIDTH), np.float32))

    def close(self):
        self.closed = True


def image_handles(box):
    places = {name: {"at_0": zero, "at_1": one} for name, (zero, one) in zip(box.names, HANDLES, strict=False)}
    return ImageHandles(width=WIDTH, height=HEIGHT, joints=places)


def rig_of(box, labels=tuple("ABCDE"), *, truth="verdict", operator=None, panel=None, facts=None, **limits):
    """A rig of scripted parts, its arm and its camera."""
    panel, breaks = panel or lay_out_panel(box), {one: limits.pop(one) for one in ("at", "instead") if one in limits}
    arm = Breaking(box, panel.handle_path, **breaks)
    camera, operator = DrawnCamera(arm), operator or Willing()
    rig = Rig(
        box,
        labels=labels[: len(box.joints)],
        arm=Bounded(arm, Bounds(**{**SPACE, "answer": 60.0, **limits}), operator),
        panel=panel,
        operator=operator,
        truth=CameraSight(camera, image_handles(box)) if truth == "camera" else truth,
        rung="scripted",
        facts=facts,
    )
    return rig, arm, camera


def faulty_rig(*, box, labels, rng):
    """A rig whose arm loses its connection in the first trial that is played in this process."""
    return rig_of(box, labels, at=10**9 if BROKEN else 30, instead=_lost)[0]


def calibrated_rig(*, box, labels, rng):
    """A rig of scripted parts whose board's pose comes from the calibration that is named in ``CALIBRATION``."""
    panel, facts = calibrated_board(box, CALIBRATION["path"])
    rig, arm, _ = rig_of(box, labels, panel=panel, facts=facts)
    CONNECTED.append(arm)
    return rig


faulty_rig.attended = calibrated_rig.attended = True
BROKEN, CONNECTED, CALIBRATION = [], [], {}


def _lost(arm):
    BROKEN.append(arm)
    raise ConnectionResetError("cable")
