"""A user's settings of Matplotlib neither change nor prevent a figure, and stay as they are."""

import json
import os
import subprocess
import sys
from hashlib import sha256

import pytest

from lockprobe.boxes.families import box
from lockprobe.report.figures.boxes import box_figure
from lockprobe.report.figures.drawing import render

DRAW = """
import hashlib, json, os, sys
import scipy.stats
from lockprobe.boxes.families import box
assert "matplotlib" not in sys.modules
for folder, environment in json.loads(sys.argv[1]):
    if child := os.fork():
        assert os.waitpid(child, 0)[1] == 0
        continue
    os.chdir(folder)
    os.environ.update(environment)
    from lockprobe.report.figures.drawing import render
    from lockprobe.report.figures.boxes import box_figure
    import matplotlib as mpl
    left = mpl.rcParams["font.size"], mpl.rcParams["backend"], os.environ["MPLBACKEND"], "open" in vars(mpl)
    figure = box_figure(box("chain-4"))
    drawn = render(figure, "png"), render(figure, "svg"), render(figure, "pdf")
    print(json.dumps([[hashlib.sha256(one).hexdigest() for one in drawn], left]), flush=True)
    os._exit(0)
"""
"""Matplotlib reads the environment and the folder when it is imported: each fork imports it anew."""

CASES = {"a file": "module://no.such", "UTF-16": "nonsense", "a pipe": "svg", "a pipe by name": "TkAgg"}
"""What lies in a folder -> the backend that the environment asks for."""


@pytest.fixture(scope="module")
def drawn_elsewhere(once, tmp_path_factory):
    """Checksums of a figure that new processes draw with files of settings and backends, and what the user then has."""

    def draw():
        asked = []
        for name, backend in CASES.items():
            folder, rc = tmp_path_factory.mktemp(name.replace(" ", "-")), {}
            if "pipe" in name:
                os.mkfifo(folder / "matplotlibrc")
            else:
                coding = "utf-16" if name == "UTF-16" else "utf-8"
                (folder / "matplotlibrc").write_text("font.size: 23\ntext.usetex: True\nsavefig.bbox: tight\n", coding)
            if name == "a pipe by name":
                folder, rc = folder.parent, {"MATPLOTLIBRC": str(folder / "matplotlibrc")}
            asked.append((str(folder), {"MPLBACKEND": backend} | rc))
        command = [sys.executable, "-c", DRAW, json.dumps(asked)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=600)
        assert (done.returncode, done.stderr) == (0, "")
        return dict(zip(CASES, map(json.loads, done.stdout.splitlines()), strict=True))

    return once("drawn elsewhere", draw)


@pytest.mark.parametrize("hostile", CASES)
def test_no_settings_of_a_user_change_or_prevent_a_figure_and_they_are_kept_for_the_user(drawn_elsewhere, hostile):
    drawn, (size, backend, asked_for, opens_pipes) = drawn_elsewhere[hostile]
    figure = box_figure(box("chain-4"))
    assert drawn == [sha256(render(figure, form)).hexdigest() for form in ("png", "svg", "pdf")]
    assert (size, asked_for, opens_pipes) == (23.0 if hostile == "a file" else 10.0, CASES[hostile], False)
    assert backend == CASES[hostile] or hostile in ("UTF-16", "a file")
