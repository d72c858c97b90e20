"""Files of learners: what is damaged or hostile is refused in one line, and runs no code."""

import io
import json
import pickle
import zipfile

import numpy as np
import pytest

from lockprobe.errors import BadFile
from lockprobe.learner.network import shapes
from lockprobe.learner.network_file import SHIPPED, load, shipped

TRAINING = {"updates": 1, "joints": 2, "hidden": 3, "seed": 1, "told_lies": False, "schedule": 900, "box": ""}


def written(path, training=TRAINING, **changed):
    """A file with members as given: arrays, or raw bytes; None leaves one out."""
    arrays = {name: np.zeros(shape, "<f4") for name, shape in shapes(2, 3).items()} | changed
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("training.json", training if isinstance(training, str) else json.dumps(training))
        for name, array in arrays.items():
            content = io.BytesIO()
            if isinstance(array, np.ndarray):
                np.lib.format.write_array(content, array)
            if array is not None:
                archive.writestr(f"{name}.npy", array if isinstance(array, bytes) else content.getvalue())
    return path


def test_a_file_as_it_should_be(tmp_path):
    assert load(written(tmp_path / "fine.npz")).network.joints == 2
    for name in SHIPPED:
        found = shipped(name)
        assert found.trained.command.startswith(f"lockprobe learn --updates {found.trained.updates} ")
        assert len(found.sha256) == 64


class Harm:
    def __reduce__(self):
        return (pytest.fail, ("code of the file ran",))


PICKLED = io.BytesIO()
np.lib.format.write_array(PICKLED, np.array([Harm()], dtype=object), allow_pickle=True)


@pytest.mark.parametrize(
    "wrong",
    [
        {"layer": None},
        {"layer": np.zeros((3, 4), "<f4")},
        {"layer": np.zeros((3, 3), "<f8")},
        {"layer": np.full((3, 3), np.nan, "<f4")},
        {"layer": PICKLED.getvalue()},
        {"layer": pickle.dumps(Harm())},
        {"layer": bytes(1_000_000)},
        {"layer": b""},
        {"training": "{"},
        {"training": "[]"},
        {"training": TRAINING | {"hidden": 100_000}},
        {"training": TRAINING | {"joints": 9}},
        {"training": TRAINING | {"more": 1}},
        {"training": json.dumps(TRAINING) + " " * 10_000},
    ],
)
def test_what_is_not_as_it_should_be_is_refused(tmp_path, wrong):
    with pytest.raises(BadFile, match="not the file of a learner"):
        load(written(tmp_path / "wrong.npz", **wrong))


def test_other_files_are_refused(tmp_path):
    (tmp_path / "text.npz").write_text("hello")
    whole = written(tmp_path / "fine.npz").read_bytes()
    (tmp_path / "torn.npz").write_bytes(whole[:-30])
    (tmp_path / "large.npz").write_bytes(bytes(3 << 20))
    for name in ("text", "torn", "large", "missing"):
        with pytest.raises(BadFile):
            load(tmp_path / f"{name}.npz")
