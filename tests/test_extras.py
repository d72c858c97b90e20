"""With any extra alone, and with none, every command works or says in one line which extra it lacks."""

import json
import os
import subprocess
import sys
from pathlib import Path

import extras
import numpy as np
import pytest
from builders import small_study, write_study


@pytest.fixture(scope="module")
def matrix(tmp_path_factory):
    directory = tmp_path_factory.mktemp("extras")
    write_study(directory / "S", small_study(["random"], p=[0.0], repetitions=1, trials=1))
    (directory / "V").mkdir()
    (directory / "V" / "0.png").write_bytes(b"x")
    camera = {"width": 64, "height": 64, "focal": [64, 64], "centre": [4, 4]}
    view = {"picture": "0.png", "hand": np.eye(4).tolist()}
    (directory / "V" / "views.json").write_text(json.dumps({"camera": camera, "views": [view]}))
    without = {name: value for name, value in os.environ.items() if not name.endswith("_API_KEY")}
    done = subprocess.run(
        [sys.executable, str(Path(extras.__file__)), str(directory)], capture_output=True, text=True, env=without
    )
    assert done.returncode == 0, done.stderr
    return dict(json.loads(line) for line in done.stdout.splitlines())


@pytest.mark.parametrize("extra", ["", *extras.EXTRAS])
def test_every_command_works_or_says_in_one_line_what_is_missing(matrix, extra):
    found = matrix[extra]
    for command in extras.PLAIN:
        assert found[command][0] == 0, (command, found[command])
    for need, those in extras.NEEDS.items():
        for command in (command for command in those if command in found):
            status, lines = found[command]
            assert (status, len(lines)) == (2, 1), (command, status, lines)
            assert any(extras.EXTRAS[name] in lines[0] for name in (need, "twin")), (command, lines)


def test_what_an_extra_brings_is_read_from_the_projects():
    core = extras.distributions(["lockprobe"])
    assert {"lockprobe", "numpy", "pydantic-core", "matplotlib"} <= core
    assert not {"openai", "inspect-ai", "starlette", "mujoco", "pandas", "statsmodels", "lockprobe-robot"} & core
    assert {"lockprobe", "lockprobe-robot", "mujoco"} <= extras.distributions(["lockprobe[twin]"])
    assert {"mujoco", "imageio-ffmpeg"} <= extras.distributions(["lockprobe-robot[film]"])
    assert "tenacity" in extras.distributions(["lockprobe[inspect]"])
    assert len(extras.EXTRAS) <= 16
