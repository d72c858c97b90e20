"""Models of boxes for tests."""

from pathlib import Path

from lockprobe_robot.box_model.mjcf import write_model

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.boxfile import read_box

EXAMPLES = Path(__file__).parents[1] / "examples"
OWN = EXAMPLES / "own_box.xml"

ONE = """<mujoco>{head}<worldbody><body>
<joint name="bolt" type="slide" axis="1 0 0" range="0 0.1" damping="5" frictionloss="1"/>
<geom size=".02" mass="0.5"/>{inside}</body>{outside}</worldbody></mujoco>"""
"""One joint that is always free, with places for what a test adds."""


def own_box():
    return read_box(EXAMPLES / "own_box.toml")


def one_joint():
    return Lockbox(
        name="one", joints=(Joint(name="bolt", kind="prismatic"),), interlock={}, initial=(False,), target="bolt"
    )


def written(folder, text=None, **parts):
    """A file with one joint, or with ``text``."""
    path = folder / "box.xml"
    path.write_text(text or ONE.format(**{"head": "", "inside": "", "outside": "", **parts}), "utf-8")
    return path


def exported(box, folder):
    """Our own scene of a box as a user's file."""
    path = folder / f"{box.name}.xml"
    write_model(box, path)
    return path
