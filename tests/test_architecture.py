"""The house stands as ARCHITECTURE.md says."""

import ast
import importlib
import pkgutil
import re
from fnmatch import fnmatch
from pathlib import Path

import pytest

import lockprobe

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "lockprobe"
FILES = sorted(path.relative_to(SOURCE).as_posix() for path in SOURCE.rglob("*.py"))
ENGINES = (
    "lockprobe.agents.llm.client",
    "lockprobe.agents.llm.model",
    "lockprobe.agents.llm.connect",
    "lockprobe.agents.engine",
    "lockprobe.__main__",
)
MODULES = [m.name for m in pkgutil.walk_packages(lockprobe.__path__, "lockprobe.") if m.name not in ENGINES]


TOGETHER = "interventions/*.py"
"""Files that one line stands for: adding an intervention adds none."""


def test_the_inventory_names_every_file_and_no_other():
    named = re.findall(r"^\s+([a-z_/*]+\.py)\s{2,}", (ROOT / "ARCHITECTURE.md").read_text("utf-8"), re.MULTILINE)
    alone = {name for name in named if name != TOGETHER}
    assert len(named) == len(alone) + 1
    files = {name for name in FILES if not name.endswith("__init__.py") or name == "cli/__init__.py"}
    assert alone <= files
    assert {name for name in files - alone if not fnmatch(name, TOGETHER)} == set()


@pytest.mark.parametrize("name", MODULES)
def test_public_names_exist_and_are_complete(name):
    module = importlib.import_module(name)
    if hasattr(module, "__path__") and not hasattr(module, "__all__"):
        return  # a package that exports nothing of its own
    exported = list(module.__all__)
    assert len(set(exported)) == len(exported)
    assert all(hasattr(module, public) for public in exported)
    defined = {
        public
        for public, thing in vars(module).items()
        if not public.startswith("_") and getattr(thing, "__module__", None) == name and hasattr(thing, "__qualname__")
    }
    assert defined - set(exported) == set()


@pytest.mark.parametrize("name", FILES)
def test_no_file_is_a_drawer(name):
    text = (SOURCE / name).read_text("utf-8")
    assert text.count("\n") <= 450
    assert Path(name).stem not in {"utils", "util", "helpers", "common", "misc"}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            assert node.end_lineno - node.lineno < 60, f"{node.name} is long"


def test_broad_excepts_stand_where_anybody_s_code_runs_and_nowhere_else():
    broad = [name for name in FILES if re.search(r"except (Base)?Exception\b", (SOURCE / name).read_text("utf-8"))]
    assert broad == ["plugins.py", "trial.py"]
