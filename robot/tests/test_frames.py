"""Frames as files: a point is found in them where their own camera says it is."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from builders import small_study, write_study
from painted import painted_twins
from PIL import Image
from typed import in_process

from lockprobe.foundation.errors import BadFile, BadValue


def exported(directory, out, *words):
    in_process("export", directory, "--format", "frames", "--out", out, *words)
    return [json.loads(line) for line in (out / "frames.jsonl").read_text("utf-8").splitlines()]


@pytest.fixture
def study(tmp_path):
    short = replace(small_study(["human-inspired"], p=(0.4,), repetitions=1, trials=1), max_steps=2)
    return write_study(tmp_path / "study", short)


def test_every_handle_is_within_a_pixel_of_where_its_place_is_projected(study, tmp_path):
    lines = exported(study, tmp_path / "frames")
    for line in (lines[0], lines[-1]):
        depth = np.asarray(Image.open(tmp_path / "frames" / line["depth"])).astype(float) / 1000
        assert depth.shape == (line["height"], line["width"])
        pose = np.array(line["panel_in_camera"])
        columns, rows = np.meshgrid(np.arange(line["width"]), np.arange(line["height"]))
        rays = np.stack(
            [(columns - line["cx"]) / line["fx"], (rows - line["cy"]) / line["fy"], np.ones_like(depth)], axis=-1
        )
        points = (rays * depth[..., None] - pose[:3, 3]) @ pose[:3, :3]
        for at, places in zip(line["state"], line["handles"].values(), strict=True):
            seen = pose[:3, :3] @ np.array(places[int(at)]) + pose[:3, 3]
            pixel = seen[:2] / seen[2] * (line["fx"], line["fy"]) + (line["cx"], line["cy"])
            near = np.linalg.norm(points[..., :2] - places[int(at)][:2], axis=-1) < 0.02
            top = near & (points[..., 2] > 0.0485)  # a cap of the round top of the handle
            found = np.array([columns[top].mean(), rows[top].mean()])
            assert top.sum() > 20
            assert np.linalg.norm(found - pixel) < 1


def test_a_frame_has_its_picture_and_what_was_true_and_told(study, tmp_path, monkeypatch):
    painted_twins(monkeypatch)
    lines = exported(study, tmp_path / "frames", "--trial", "human-inspired/flip?p=0.4/rep=1/trial=1")
    assert [line["step"] for line in lines] == list(range(len(lines)))
    assert "joint" not in lines[0]
    assert {line["told_moved"] for line in lines[1:]} <= {True, False}
    for before, line in pairwise(lines):
        assert (before["state"] != line["state"]) == line["moved"]
        with Image.open(tmp_path / "frames" / line["rgb"]) as rgb:
            assert (rgb.mode, rgb.size) == ("RGB", (line["width"], line["height"]))


def test_what_cannot_be_written_is_refused(study, tmp_path, monkeypatch):
    painted_twins(monkeypatch)
    with pytest.raises(BadValue, match="--trial: got 'nothing', expected the key of a trial"):
        exported(study, tmp_path / "frames", "--trial", "nothing")
    with pytest.raises(BadFile, match="is there and not an empty directory"):
        exported(study, study)
    assert not (tmp_path / "frames").exists()
