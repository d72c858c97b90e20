"""A user's settings of Matplotlib neither change nor prevent a figure, and stay as they are."""

import inspect
import json
import os
import subprocess
import sys
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

import matplotlib as mpl
import pytest
from drawn import pictures

from lockprobe.boxes.families import box
from lockprobe.report import figures
from lockprobe.report.figures import own_settings, render
from lockprobe.report.figures.boxes import box_figure

HOSTILE = {
    "font.size": 23.0,
    "font.family": ["monospace"],
    "text.usetex": True,
    "axes.facecolor": "black",
    "figure.constrained_layout.use": True,
    "savefig.bbox": "tight",
    "svg.fonttype": "none",
    "lines.linewidth": 9.0,
    "path.simplify": False,
}
"""Settings as some journals' styles have them; TeX is not installed."""

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
    from lockprobe.report.figures import render
    from lockprobe.report.figures.boxes import box_figure
    print(*(hashlib.sha256(render(box_figure(box("chain-4")), form)).hexdigest() for form in ("png", "svg")), flush=True)
    os._exit(0)
"""
"""Matplotlib reads the environment and the folder when it is imported: each fork imports it anew."""

BACKENDS = ("module://matplotlib_inline.backend_inline", "module://no.such", "nonsense", "TkAgg", "")


@pytest.fixture(scope="module")
def drawn_elsewhere(tmp_path_factory):
    """Checksums of a figure that new processes draw: one for each backend, and one beside a file of settings."""
    plain, with_file = tmp_path_factory.mktemp("plain"), tmp_path_factory.mktemp("with file")
    (with_file / "matplotlibrc").write_text("font.size: 23\ntext.usetex: True\nsavefig.bbox: tight\n", "utf-8")
    asked = {name: (str(plain), {"MPLBACKEND": name}) for name in BACKENDS} | {"a file": (str(with_file), {})}
    command = [sys.executable, "-c", DRAW, json.dumps([*asked.values()])]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return dict(zip(asked, map(str.split, done.stdout.splitlines()), strict=True))


@pytest.fixture(scope="module")
def drawn_here():
    figure = box_figure(box("chain-4"))
    return [sha256(render(figure, form)).hexdigest() for form in ("png", "svg")]


def test_the_user_s_settings_change_no_byte_of_any_figure(studies):
    plain = {name: render(figure, "svg") for name, figure in pictures(studies["people"]).items()}
    with mpl.rc_context(HOSTILE):
        assert {name: render(figure, "svg") for name, figure in pictures(studies["people"]).items()} == plain
        assert {name: mpl.rcParams[name] for name in HOSTILE} == HOSTILE


def test_every_function_that_makes_a_figure_or_a_file_has_our_settings():
    for found in iter_modules([str(Path(figures.__file__).parent)]):
        module = import_module(f"lockprobe.report.figures.{found.name}")
        for name, made in inspect.getmembers(module, inspect.isfunction):
            if made.__module__ != module.__name__ or name.startswith("_"):
                continue
            if str(inspect.signature(made).return_annotation) in ("Figure", "Figure | None", "bytes"):
                assert hasattr(made, "__wrapped__"), f"{module.__name__}.{name}"


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_notebook_s_backend_changes_nothing(drawn_elsewhere, drawn_here, backend):
    assert drawn_elsewhere[backend] == drawn_here


def test_a_file_of_settings_changes_nothing(drawn_elsewhere, drawn_here):
    assert drawn_elsewhere["a file"] == drawn_here


def test_a_file_of_settings_that_cannot_be_read_is_one_line(tmp_path):
    (tmp_path / "matplotlibrc").write_bytes(b"font.size: \xff\xfe\n")
    done = subprocess.run(
        [sys.executable, "-m", "lockprobe", "box", "show", "chain-4", "--out", "box.svg"],
        cwd=tmp_path, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("lockprobe: matplotlibrc: Matplotlib, which draws the figures, ")
    assert "Traceback" not in done.stderr


def test_the_user_s_backend_is_kept_for_the_user(tmp_path):
    code = "import lockprobe.report.figures, matplotlib as mpl, os; print(mpl.rcParams['backend'], os.environ['MPLBACKEND'])"
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "MPLBACKEND": "svg"}, capture_output=True, text=True
    )
    assert done.stdout.split() == ["svg", "svg"]


def test_settings_return_after_an_error():
    def fail():
        assert mpl.rcParams["font.size"] == 9.0
        raise ZeroDivisionError

    with mpl.rc_context({"font.size": 23.0}):
        with pytest.raises(ZeroDivisionError):
            own_settings()(fail)()
        assert mpl.rcParams["font.size"] == 23.0
