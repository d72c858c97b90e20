"""A user's settings of Matplotlib neither change nor prevent a figure."""

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
from lockprobe.report.figures.drawing import render
from lockprobe.report.figures.boxes import box_figure
from lockprobe.boxes.families import box
figure = box_figure(box("chain-4"))
drawn = [hashlib.sha256(render(figure, form)).hexdigest() for form in ("png", "svg", "pdf")]
print(json.dumps([*drawn, os.environ.get("MATPLOTLIBRC"), os.environ["MPLBACKEND"]]))
"""


@pytest.mark.parametrize("hostile", ["in the folder", "by name"])
def test_no_settings_of_a_user_change_or_prevent_a_figure(tmp_path, hostile):
    """A pipe that a reader waits for, or a text of another coding."""
    file = tmp_path / "matplotlibrc"
    if hostile == "by name":
        os.mkfifo(file)
    else:
        file.write_text("font.size: 23\ntext.usetex: True\nsavefig.bbox: tight\n", "utf-16")
    named = {"MATPLOTLIBRC": str(file)} if hostile == "by name" else {}
    folder = tmp_path.parent if named else tmp_path
    done = subprocess.run(
        [sys.executable, "-c", DRAW], cwd=folder, env=os.environ | {"MPLBACKEND": "module://no.such"} | named,
        capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    figure = box_figure(box("chain-4"))
    drawn = [sha256(render(figure, form)).hexdigest() for form in ("png", "svg", "pdf")]
    assert json.loads(done.stdout) == [*drawn, named.get("MATPLOTLIBRC"), "module://no.such"]
