"""With no extra at all, every command works or says in one line which extra it lacks.

Nothing is installed for that: a process in which what the core does not require cannot be imported plays the commands.
"""

import contextlib
import io
import json
import os
import subprocess
import sys
import tomllib
from importlib.machinery import PathFinder
from importlib.metadata import packages_distributions
from pathlib import Path

import numpy as np
import pytest
from builders import small_study, write_study
from packaging.utils import canonicalize_name

SITE = {"cmeel_pth"}
"""What a package imports by itself when any interpreter starts, by a file in site-packages."""

KEY = "flips/random/truth/rep=1/trial=1"
PLAIN = ("chance", "list agents", "export S", "status S", "doctor llm:ollama/x")
"""Commands that need no extra. The last asks over HTTP, and ends with 1, since nobody is there."""

NEEDS = {
    "run flips --agent llm:local --p 0 --trials 1 --out R": "--extra local",
    "box show chain-4 --out b.xml": "--extra twin",
    "box check chain-4 b.xml": "--extra twin",
    "run modalities --agent viewer --plant fast-twin --trials 1 --out M": "--extra twin",
    f"replay S {KEY} --out f.gif": "--extra twin",
    "export S --format parquet --out e.parquet": "--extra parquet",
    "serve flips --out P": "--extra web",
    "mcp flips": "--extra mcp",
    "run flips --agent random --p 0 --trials 1 --cluster auto --out C": "--extra cluster",
    "rig calibrate V": "--extra twin",
}
"""Command -> the extra that it asks for."""

LOCK = tomllib.loads((Path(__file__).parents[1] / "uv.lock").read_text("utf-8"))["package"]


def core():
    """The names of what is installed with the core alone."""
    requires = {one["name"]: [each["name"] for each in one.get("dependencies", ())] for one in LOCK}
    found, waiting = set(), ["lockprobe"]
    while waiting:
        if (name := waiting.pop()) not in found:
            found.add(name)
            waiting += requires[name]
    return found


class OnlyCore:
    """Finds modules and distributions as usual, but for those that the core does not require."""

    def __init__(self):
        self._core = core()
        tops = packages_distributions().items()
        self.hidden = {top for top, names in tops if not {canonicalize_name(name) for name in names} & self._core}
        self.hidden -= {*SITE, *sys.stdlib_module_names}

    def find_distributions(self, context):
        return [one for one in PathFinder.find_distributions(context) if canonicalize_name(one.name) in self._core]

    def find_spec(self, name, path=None, target=None):
        return None if name.partition(".")[0] in self.hidden else PathFinder.find_spec(name, path, target)


def came_to(command):
    """Exit status and lines on standard error of one command."""
    from lockprobe.cli import main

    said = io.StringIO()
    sys.argv = ["lockprobe", *command.split()]
    status = 0
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        try:
            main()
        except SystemExit as end:
            status = end.code or 0
        except BaseException as error:  # noqa: BLE001 - a traceback is what this is about
            status, said = "traceback", io.StringIO(f"{type(error).__name__}: {error}")
    return status, said.getvalue().splitlines()


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What every command came to."""
    directory = tmp_path_factory.mktemp("extras")
    write_study(directory / "S", small_study(["random"], p=[0.0], repetitions=1, trials=1))
    (directory / "V").mkdir()
    (directory / "V" / "0.png").write_bytes(b"x")
    camera = {"width": 64, "height": 64, "focal": [64, 64], "centre": [4, 4]}
    view = {"picture": "0.png", "hand": np.eye(4).tolist()}
    (directory / "V" / "views.json").write_text(json.dumps({"camera": camera, "views": [view]}))
    environment = {name: value for name, value in os.environ.items() if not name.endswith("_API_KEY")}
    environment["PYTHONPATH"] = str(Path(__file__).parent)
    done = subprocess.run(
        [sys.executable, "-c", ALONE], cwd=directory, capture_output=True, text=True, check=False, env=environment
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


ALONE = """
import json, sys
from importlib.machinery import PathFinder
from test_extras import NEEDS, PLAIN, OnlyCore, came_to
finder = OnlyCore()
for name in [name for name in sys.modules if name.partition(".")[0] in {"lockprobe", *finder.hidden}]:
    del sys.modules[name]
sys.meta_path[sys.meta_path.index(PathFinder)] = finder
print(json.dumps({command: came_to(command) for command in (*PLAIN, *NEEDS)}))
"""


def test_every_command_works_or_says_in_one_line_what_is_missing(found):
    for command in PLAIN:
        assert found[command][0] == (command == PLAIN[-1]), (command, found[command])
    for command, extra in NEEDS.items():
        status, lines = found[command]
        assert (status, len(lines)) == (2, 1), (command, status, lines)
        assert extra in lines[0], (command, lines)
