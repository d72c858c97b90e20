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
from lockprobe.report.figures import own_settings, pages_as_pdf, render
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
    from lockprobe.report.figures import pages_as_pdf, render
    from lockprobe.report.figures.boxes import box_figure
    figure = box_figure(box("chain-4"))
    drawn = render(figure, "png"), render(figure, "svg"), pages_as_pdf([figure])
    print(*(hashlib.sha256(one).hexdigest() for one in drawn), flush=True)
    os._exit(0)
"""
"""Matplotlib reads the environment and the folder when it is imported: each fork imports it anew."""

BACKENDS = ("module://matplotlib_inline.backend_inline", "module://no.such", "nonsense", "TkAgg", "")


@pytest.fixture(scope="module")
def drawn_elsewhere(tmp_path_factory):
    """Checksums of a figure that new processes draw, with each backend and with files of settings."""
    plain, settings = tmp_path_factory.mktemp("plain"), "font.size: 23\ntext.usetex: True\nsavefig.bbox: tight\n"
    asked = {name: (str(plain), {"MPLBACKEND": name}) for name in BACKENDS}
    for name, coding in (("a file", "utf-8"), ("UTF-16", "utf-16"), ("UTF-16 without a mark", "utf-16-le")):
        folder = tmp_path_factory.mktemp(coding)
        (folder / "matplotlibrc").write_text(settings, coding)
        asked[name] = (str(folder), {})
    pipe = tmp_path_factory.mktemp("pipe")
    os.mkfifo(pipe / "matplotlibrc")
    asked |= {"a pipe": (str(pipe), {}), "a pipe by name": (str(plain), {"MATPLOTLIBRC": str(pipe / "matplotlibrc")})}
    command = [sys.executable, "-c", DRAW, json.dumps([*asked.values()])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert (done.returncode, done.stderr) == (0, "")
    return dict(zip(asked, map(str.split, done.stdout.splitlines()), strict=True))


@pytest.fixture(scope="module")
def drawn_here():
    figure = box_figure(box("chain-4"))
    drawn = render(figure, "png"), render(figure, "svg"), pages_as_pdf([figure])
    return [sha256(one).hexdigest() for one in drawn]


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


@pytest.mark.parametrize("hostile", ["a file", "a pipe", "a pipe by name", "UTF-16", "UTF-16 without a mark"])
def test_no_file_of_settings_changes_or_prevents_a_figure(drawn_elsewhere, drawn_here, hostile):
    assert drawn_elsewhere[hostile] == drawn_here


def test_the_user_s_backend_and_settings_are_kept_for_the_user(tmp_path):
    (tmp_path / "matplotlibrc").write_text("font.size: 23\n", "utf-8")
    code = (
        "import lockprobe.report.figures, matplotlib as mpl, os\n"
        "print(mpl.rcParams['backend'], os.environ['MPLBACKEND'], mpl.rcParams['font.size'], 'open' in vars(mpl))"
    )
    settings = {"env": {**os.environ, "MPLBACKEND": "svg"}, "cwd": tmp_path}
    done = subprocess.run([sys.executable, "-c", code], **settings, capture_output=True, text=True)
    assert done.stdout.split() == ["svg", "svg", "23.0", "False"]


def test_settings_return_after_an_error():
    def fail():
        assert mpl.rcParams["font.size"] == 9.0
        raise ZeroDivisionError

    with mpl.rc_context({"font.size": 23.0}):
        with pytest.raises(ZeroDivisionError):
            own_settings()(fail)()
        assert mpl.rcParams["font.size"] == 23.0
