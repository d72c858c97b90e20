"""Every extra of both distributions alone, without installing anything: what is in neither the core nor the extra cannot be imported.

``python tests/extras.py DIRECTORY`` imports the core once, then forks for every extra, plays the commands there and
prints, as JSON, what each came to. DIRECTORY holds a study (``S``).
"""

import contextlib
import io
import json
import os
import sys
import tomllib
from functools import cache
from importlib.machinery import PathFinder
from importlib.metadata import DistributionFinder, PackageNotFoundError, packages_distributions, requires
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from lockprobe.foundation import plugins

SITE = {"cmeel_pth"}
"""What a package imports by itself when any interpreter starts, by a file in site-packages."""

KEY = "flips/random/truth/rep=1/trial=1"
PLAIN = ("chance", "list agents", "export S", "status S", "doctor llm:ollama/x")
"""Commands that need no extra. The last asks over HTTP, and says that nobody is there."""

NEEDS = {
    "local": ("run flips --agent llm:local --p 0 --trials 1 --out R",),
    "twin": (
        "box show chain-4 --out b.xml",
        "box check chain-4 b.xml",
        "run modalities --agent viewer --plant fast-twin --trials 1 --out M",
        f"replay S {KEY} --out f.gif",
    ),
    "film": (f"replay S {KEY} --out f.mp4",),
    "parquet": ("export S --format parquet --out e.parquet",),
    "web": ("serve flips --out P",),
    "mcp": ("mcp flips",),
    "cluster": ("run flips --agent random --p 0 --trials 1 --cluster auto --out C",),
    "calibrate": ("rig calibrate V",),
}
"""Extra -> commands that cannot be had without it."""

WITHIN = {
    "film": {"twin", "film"},
    "calibrate": {"twin", "calibrate"},
    "realsense": {"twin"},
    "inspect": {"inspect", "web"},
    "mcp": {"web", "mcp"},
    "fr3": {"twin", "fr3"},
}
"""Extra -> the extras that it brings, where that is more than itself."""

ROOT = Path(__file__).parents[1]
PROJECTS = {
    name: tomllib.loads((ROOT / folder / "pyproject.toml").read_text("utf-8"))["project"]
    for name, folder in {"lockprobe": ".", "lockprobe-robot": "robot"}.items()
}
EXTRAS = {extra: f"{name}[{extra}]" for name, project in PROJECTS.items() for extra in project["optional-dependencies"]}
"""Extra -> the requirement that installs it."""


def distributions(requirements):
    """The names of what is installed with these requirements, with all that they require in turn."""
    found, waiting = set(), [Requirement(one) for one in requirements]
    done = set()
    while waiting:
        one = waiting.pop()
        name, extras = canonicalize_name(one.name), frozenset(one.extras)
        if one.marker and not any(one.marker.evaluate({"extra": extra}) for extra in ("", *extras)):
            continue
        if (name, extras) in done:
            continue
        done.add((name, extras))
        found.add(name)
        if name in PROJECTS:
            own = PROJECTS[name]
            waiting += map(Requirement, own["dependencies"])
            waiting += [Requirement(inner) for extra in extras for inner in own["optional-dependencies"][extra]]
            continue
        with contextlib.suppress(PackageNotFoundError):
            inner = map(Requirement, requires(name) or ())
            waiting += [
                each
                for each in inner
                if not each.marker or any(each.marker.evaluate({"extra": extra}) for extra in ("", *extras))
            ]
            for each in waiting:
                each.marker = None
    return found


@cache
def _installed(name, path):
    """What is installed, by its name, whether or not it is to be there: to read all names takes a tenth of a second."""
    context = DistributionFinder.Context(name=name, path=list(path))
    return [(canonicalize_name(one.name), one) for one in PathFinder.find_distributions(context)]


class Only:
    """Finds modules as usual, but for those of distributions that are not there."""

    def __init__(self, allowed):
        self._known = {
            top: {canonicalize_name(name) for name in names} for top, names in packages_distributions().items()
        }
        self.allow(allowed)

    def allow(self, allowed):
        self._allowed = allowed
        self.hidden = {top for top, names in self._known.items() if not names & allowed}
        self.hidden -= {*SITE, *sys.stdlib_module_names}
        plugins._points_on.cache_clear()

    def find_distributions(self, context):
        return [one for name, one in _installed(context.name, tuple(context.path)) if name in self._allowed]

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


def commands(extra):
    brought = WITHIN.get(extra, {extra})
    return [*PLAIN, *(command for need, those in NEEDS.items() if need not in brought for command in those)]


def main():
    os.chdir(sys.argv[1])
    # read while all that is installed can be found
    allowed = {extra: distributions([EXTRAS.get(extra, "lockprobe")]) for extra in ("", *EXTRAS)}
    finder = Only(allowed[""])
    sys.meta_path[sys.meta_path.index(PathFinder)] = finder
    import lockprobe.cli

    lockprobe.cli.build(lockprobe.cli.COMMANDS)
    finder.find_distributions(DistributionFinder.Context())  # read before the forks
    for extra in ("", *EXTRAS):
        sys.stdout.flush()
        if child := os.fork():
            os.waitpid(child, 0)
            continue
        finder.allow(allowed[extra])
        for name in [name for name in sys.modules if name.partition(".")[0] in finder.hidden]:
            raise SystemExit(f"{name} was imported without its extra")
        print(json.dumps([extra, {command: came_to(command) for command in commands(extra)}]), flush=True)
        os._exit(0)


if __name__ == "__main__":
    main()
