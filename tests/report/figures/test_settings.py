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

FILES = {"a file": "utf-8", "UTF-16": "utf-16", "UTF-16 without a mark": "utf-16-le"}
BACKENDS = {
    "a file": "module://no.such",
    "UTF-16": "nonsense",
    "UTF-16 without a mark": "module://matplotlib_inline.backend_inline",
    "a pipe": "svg",
    "a pipe by name": "TkAgg",
}


@pytest.fixture(scope="module")
def drawn_elsewhere(once, tmp_path_factory):
    """Checksums of a figure that new processes draw with files of settings and backends, and what the user then has."""
    return once("drawn elsewhere", lambda: draw_elsewhere(tmp_path_factory))


def draw_elsewhere(tmp_path_factory):
    pipe, plain = (tmp_path_factory.mktemp(name) for name in ("pipe", "plain"))
    os.mkfifo(pipe / "matplotlibrc")
    folders, asked = {"a pipe": pipe}, []
    for name, coding in FILES.items():
        folders[name] = tmp_path_factory.mktemp(coding)
        settings = "font.size: 23\ntext.usetex: True\nsavefig.bbox: tight\n"
        (folders[name] / "matplotlibrc").write_text(settings, coding)
    for name, backend in BACKENDS.items():
        rc = {"MATPLOTLIBRC": str(pipe / "matplotlibrc")} if name == "a pipe by name" else {}
        asked.append((str(folders.get(name, plain)), {"MPLBACKEND": backend} | rc))
    command = [sys.executable, "-c", DRAW, json.dumps(asked)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert (done.returncode, done.stderr) == (0, "")
    return dict(zip(BACKENDS, map(json.loads, done.stdout.splitlines()), strict=True))


@pytest.fixture(scope="module")
def drawn_here():
    figure = box_figure(box("chain-4"))
    drawn = render(figure, "png"), render(figure, "svg"), render(figure, "pdf")
    return [sha256(one).hexdigest() for one in drawn]


@pytest.mark.parametrize("hostile", BACKENDS)
def test_no_settings_of_a_user_change_or_prevent_a_figure_and_they_are_kept_for_the_user(
    drawn_elsewhere, drawn_here, hostile
):
    drawn, (size, backend, asked_for, opens_pipes) = drawn_elsewhere[hostile]
    assert drawn == drawn_here
    assert (size, asked_for, opens_pipes) == (23.0 if hostile == "a file" else 10.0, BACKENDS[hostile], False)
    assert backend == BACKENDS[hostile] or hostile in ("UTF-16", "a file")
