"""A user's settings of Matplotlib neither change nor prevent a figure."""

import json
import os
import subprocess
import sys
from hashlib import sha256

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


def test_no_settings_of_a_user_change_or_prevent_a_figure(tmp_path):
    """A text of another coding in the folder, and by name a pipe that a reader waits for."""
    (tmp_path / "matplotlibrc").write_text("font.size: 23\ntext.usetex: True\n", "utf-16")
    os.mkfifo(tmp_path / "pipe")
    users = {"MPLBACKEND": "module://no.such", "MATPLOTLIBRC": str(tmp_path / "pipe")}
    done = subprocess.run(
        [sys.executable, "-c", DRAW], cwd=tmp_path, env=os.environ | users, capture_output=True, text=True, timeout=600
    )
    assert (done.returncode, done.stderr) == (0, "")
    figure = box_figure(box("chain-4"))
    drawn = [sha256(render(figure, form)).hexdigest() for form in ("png", "svg", "pdf")]
    assert json.loads(done.stdout) == [*drawn, users["MATPLOTLIBRC"], users["MPLBACKEND"]]
