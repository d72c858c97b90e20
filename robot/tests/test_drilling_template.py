"""The drilling template has the dimensions of the twin's MuJoCo model, in millimetres on paper."""

import math
import re
import xml.etree.ElementTree as ET
from functools import cache

import mujoco
import numpy as np
import pytest
from lockprobe_robot.drilling_template import drilling_template, exceeds_a3
from lockprobe_robot.scene.mjcf import write_mjcf
from lockprobe_robot.scene.panel import lay_out_panel
from lockprobe_robot.scene.tag_layout import TAG_SIDE, place_tags
from lockprobe_robot.true_scale import true_scale_file

from lockprobe.boxes.families import box

SVG = "{http://www.w3.org/2000/svg}"


@cache
def template(name):
    panel = lay_out_panel(box(name))
    return panel, drilling_template(panel, "ABCDEFGH"[: len(panel.mounted_joints)], place_tags(panel), name)


def outlines(figure):
    """Name -> points on paper in millimetres, from the lower left, read from the SVG file alone."""
    root = ET.fromstring(true_scale_file(figure, "svg"))
    width, height = (float(root.get(side).removesuffix("mm")) for side in ("width", "height"))
    _, _, wide, high = map(float, root.get("viewBox").split())
    assert wide / width == pytest.approx(high / height, rel=1e-5)
    found = {}
    for group in root.iter(f"{SVG}g"):
        path = next(iter(group.findall(f"{SVG}path")), None)
        if path is not None:
            numbers = np.array([float(x) for x in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", path.get("d"))]).reshape(-1, 2)
            found[group.get("id")] = np.array([0, height]) + numbers * (width / wide, -height / high)
    return found


def bounds(points):
    return points.min(0), points.max(0)


@pytest.mark.parametrize("name", ["chain-4", "random-3-4"])
def test_dimensions_on_paper_are_those_of_the_model(name, tmp_path):
    panel, figure = template(name)
    drawn = outlines(figure)
    write_mjcf(box(name), tmp_path / "box.xml", labels=tuple("ABCDEFGH"[: len(panel.mounted_joints)]))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "box.xml"))
    low, high = bounds(drawn["board"])
    np.testing.assert_allclose(high - low, 2000 * model.geom("board").size[:2], atol=0.01)
    middle = (low + high) / 2
    data = mujoco.MjData(model)
    turned = model.body("panel").id
    for number, own in enumerate(box(name).names):
        joint = model.joint(own)
        ends = []
        for position in joint.range:
            data.qpos[joint.qposadr] = position
            mujoco.mj_kinematics(model, data)
            knob = data.site(own).xpos - data.xpos[turned]
            ends.append(middle + 1000 * (data.xmat[turned].reshape(3, 3).T @ knob)[:2])
        for end, position in zip(ends, ("closed", "open"), strict=True):
            np.testing.assert_allclose(np.mean(bounds(drawn[f"handle-{number}-{position}"]), axis=0), end, atol=0.02)
        if joint.type == mujoco.mjtJoint.mjJNT_SLIDE:
            low, high = bounds(drawn[f"slot-{number}"])
            np.testing.assert_allclose((low + high) / 2, np.mean(ends, axis=0), atol=0.02)
            np.testing.assert_allclose(high - low, np.abs(ends[1] - ends[0]) + 14, atol=0.02)
        else:
            pivot = middle + 1000 * model.body(f"part-{number}").pos[:2]
            np.testing.assert_allclose(np.mean(bounds(drawn[f"axis-{number}"]), axis=0), pivot, atol=0.02)
            swing = drawn[f"swing-{number}"]
            first, last = (math.atan2(*(point - pivot)[::-1]) for point in (swing[0], swing[-1]))
            assert (last - first) % (2 * math.pi) == pytest.approx(joint.range[1], abs=0.001)


def test_the_ruler_is_100_mm_and_tags_have_their_size_and_place():
    panel, figure = template("chain-4")
    drawn = outlines(figure)
    low, high = bounds(drawn["ruler"])
    np.testing.assert_allclose(high - low, [0, 100], atol=0.01)
    middle = np.mean(bounds(drawn["board"]), axis=0)
    for number, place in enumerate(place_tags(panel).middles):
        low, high = bounds(drawn[f"tag-{number}"])
        np.testing.assert_allclose(high - low, 1000 * TAG_SIDE, atol=0.01)
        np.testing.assert_allclose((low + high) / 2, middle + 1000 * place, atol=0.01)


@pytest.mark.parametrize(("name", "expected"), [("chain-2", False), ("chain-4", True)])
def test_a_template_beyond_a3_says_so(name, expected):
    panel, figure = template(name)
    said = " ".join(text.get_text() for axes in figure.axes for text in axes.texts)
    assert exceeds_a3(panel) == expected
    assert ("larger than A3" in said) == expected


def test_every_word_is_on_the_sheet():
    _, figure = template("chain-4")
    figure.draw_without_rendering()
    for text in figure.axes[0].texts:
        place = text.get_window_extent()
        assert min(place.x0, place.y0) >= 0, text
        assert place.x1 <= figure.bbox.x1, text
        assert place.y1 <= figure.bbox.y1, text


def test_a_pdf_has_the_size_of_the_sheet_and_equal_sheets_give_equal_bytes():
    _, figure = template("chain-2")
    page = re.search(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", true_scale_file(figure, "pdf"))
    np.testing.assert_allclose([float(side) * 25.4 / 72 for side in page.groups()], [406, 292], atol=0.01)
    again = true_scale_file(template.__wrapped__("chain-2")[1], "pdf")
    assert again == true_scale_file(figure, "pdf")
