"""The page of robots says what the code and the project say."""

import math
from pathlib import Path

from lockprobe_robot.box_model.bolts import case_depth
from lockprobe_robot.box_model.gates import gates_of
from lockprobe_robot.box_model.mounted_joint import KNOB_RADIUS, KNOB_TOP, LEVER, SLIDE, SWING
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.hardware.bounds import Bounds

from lockprobe.boxes.families import box

PAGE = " ".join((Path(__file__).parents[1] / "docs" / "robot.md").read_text("utf-8").split())


def millimetres(metres):
    return f"{1000 * metres:.0f}"


def test_the_board_has_the_dimensions_of_the_twin():
    four, two = box("chain-4"), box("chain-2")
    sizes = [" x ".join(map(millimetres, lay_out_panel(one).size)) for one in (four, two)]
    assert f"For `chain-4`: a board of {sizes[0]} mm; `chain-2` is {sizes[1]} mm" in PAGE
    kinds = [joint.kind for joint in four.joints]
    slides, turns, gates = kinds.count("prismatic"), kinds.count("revolute"), gates_of(four)
    assert f"| sliders | {slides} | travel of {millimetres(SLIDE)} mm" in PAGE
    swing = f"{math.degrees(SWING):.0f}"
    assert f"| levers | {turns} | handle {millimetres(LEVER)} mm from the pivot, swing of {swing} degrees" in PAGE
    across, top = millimetres(2 * KNOB_RADIUS), millimetres(KNOB_TOP)
    assert f"| handles | {slides + turns} | round, {across} mm across, {top} mm above the board" in PAGE
    limit = Bounds(low=(0, 0, 0), high=(1, 1, 1)).force
    assert f"| locks | {len(gates)} | hold a locked joint against {limit:g} N" in PAGE
    assert f"case of {millimetres(case_depth(gates))} mm for `chain-4`" in PAGE
