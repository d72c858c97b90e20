"""What Lockprobe takes from private modules of Inspect AI: each name is where it was, and only one file takes them."""

import ast
import importlib
from pathlib import Path

import pytest

pytest.importorskip("inspect_ai")

SOURCE = Path(__file__).parents[3] / "src" / "lockprobe"
ONE_FILE = SOURCE / "agents" / "llm" / "inspect_internals.py"

ADVICE = {
    "inspect_ai._util.error.PrerequisiteError": (
        "Inspect AI raises it when a key, a server or a provider's package is missing; agents/llm/connect.py and "
        "client.py turn it into one line for the user. When it moves: look where `inspect_ai.model.get_model` raises on "
        "a missing key, import that class. When there is none: catch what get_model raises."
    ),
    "inspect_ai._util.http_defaults_httpx2.LoopScopedTransport": (
        "agents/llm/connections.py gives every request on its way a pool of connections of its own, set up as this one "
        "(its `_kwargs`), because a pool looks at all its connections twice for every request. When it moves: look what "
        "`inspect_ai.model._providers.openai_compatible` gives its client as transport. When there is none: delete "
        "connections.py, which costs processor time where connections are many, and nothing else."
    ),
}


def taken():
    """The names that the one file imports from private modules."""
    return {name for name in imported(ONE_FILE) if is_private(name)}


def imported(path):
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def is_private(name):
    package, *parts = name.split(".")
    return package == "inspect_ai" and any(part.startswith("_") and not part.startswith("__") for part in parts)


@pytest.mark.parametrize("name", ADVICE)
def test_a_private_name_is_where_it_was(name):
    module, _, attribute = name.rpartition(".")
    try:
        getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        pytest.fail(f"{error}. {ADVICE[name]}")


def test_every_private_name_is_explained_here():
    assert taken() == {*ADVICE}


def test_no_other_file_imports_a_private_module():
    others = [path for path in SOURCE.rglob("*.py") if path != ONE_FILE and "inspect_ai" in path.read_text("utf-8")]
    assert not [(path.name, name) for path in others for name in imported(path) if is_private(name)]
