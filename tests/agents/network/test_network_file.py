"""Files of learners: what is damaged or hostile is refused in one line, and runs no code."""

import io
import json
import pickle
import shlex
import zipfile
from contextlib import suppress

import numpy as np
import pytest

from lockprobe import run_trial
from lockprobe.agents.network.network import shapes
from lockprobe.agents.network.network_file import SHIPPED, load, shipped
from lockprobe.foundation.errors import BadFile

TRAINING = {"updates": 1, "joints": 2, "hidden": 3, "seed": 1, "told_lies": False, "schedule": 900, "box": ""}


def written(path, training=TRAINING, packed=zipfile.ZIP_STORED, **changed):
    """A file with members as given: arrays, or raw bytes; None leaves one out."""
    arrays = {name: np.zeros(shape, "<f4") for name, shape in shapes(2, 3).items()} | changed
    with zipfile.ZipFile(path, "w", packed) as archive:
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


@pytest.mark.parametrize("name", ["x; touch /tmp/it-ran", "$(touch it-ran)", "a' b", "`id`", "-h", "two words"])
def test_the_name_of_a_box_is_one_word_of_the_command_that_trains_it_again(tmp_path, name):
    trained = load(written(tmp_path / "x.npz", training=TRAINING | {"box": name})).trained
    words = shlex.split(trained.command)
    assert words[words.index("--box") + 1] == name
    assert words[-2:] == ["--schedule", "900"]


@pytest.mark.parametrize("name", ["\x1b[2J", "a\nb", "\u202ex", "\x00"])
def test_a_name_that_changes_the_terminal_is_no_name(tmp_path, name):
    with pytest.raises(BadFile, match="not the file of a learner"):
        load(written(tmp_path / "x.npz", training=TRAINING | {"box": name}))


class Harm:
    def __reduce__(self):
        return (pytest.fail, ("code of the file ran",))


def with_header(header, version=b"\x01\x00"):
    """A layer whose header is this text."""
    text = f"{header}\n".encode()
    return b"\x93NUMPY" + version + len(text).to_bytes(2, "little") + text + bytes(36)


def of_shape(shape, descr="'<f4'", order="False"):
    return with_header(f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}")


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
        {"layer": np.full((3, 3), np.inf, "<f4")},
        {"layer": of_shape((3, 3), order="True")},
        {"layer": of_shape("(100000000000, )")},
        {"layer": of_shape(f"({'9' * 30}, )")},
        {"layer": of_shape("(True, 3)")},
        {"layer": of_shape("(3L, 3L)")},
        {"layer": of_shape((3, 3), descr="'|V2000000000'")},
        {"layer": of_shape((3, 3), descr="[('a', '<f4')]")},
        {"layer": with_header("{[]: 1}")},
        {"layer": with_header("(" * 150 + ")" * 150)},
        {"layer": with_header("{'descr': '<f4'}", version=b"\x09\x09")},
        {"packed": zipfile.ZIP_DEFLATED},
        {"packed": zipfile.ZIP_BZIP2},
        {"packed": zipfile.ZIP_LZMA},
        {"training": "[" * 2000 + "]" * 2000},
        {"training": TRAINING | {"updates": 10**300}},
        {"training": TRAINING | {"seed": 10**30}},
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
    for name in ("text", "torn", "large", "missing", 300 * "a"):
        with pytest.raises(BadFile):
            load(tmp_path / f"{name}.npz")


def test_an_encrypted_member_is_refused(tmp_path):
    content = bytearray(written(tmp_path / "fine.npz").read_bytes())
    for record, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        content[content.index(record) + flags] |= 1
    (tmp_path / "secret.npz").write_bytes(content)
    with pytest.raises(BadFile, match="not the file of a learner"):
        load(tmp_path / "secret.npz")


def test_any_changed_byte_is_a_learner_or_refused(tmp_path):
    content = written(tmp_path / "fine.npz").read_bytes()
    path = tmp_path / "changed.npz"
    for place in range(0, len(content), 3):
        path.write_bytes(content[:place] + bytes([content[place] ^ 0xFF]) + content[place + 1 :])
        with suppress(BadFile):
            assert np.isfinite(load(path).network.layer).all()


def test_the_largest_weights_give_probabilities(tmp_path):
    arrays = {name: np.full(shape, 3e38, "<f4") for name, shape in shapes(4, 3).items()}
    path = written(tmp_path / "large.npz", training=TRAINING | {"joints": 4}, **arrays)
    for step in run_trial(agent=f"learner:{path}", p=0.4, max_steps=5).steps:
        assert sum(step.decision.probabilities) == pytest.approx(1)
