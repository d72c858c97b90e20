"""The class of uvicorn that connections extend, which uvicorn does not promise to keep."""

import inspect
import re
import tomllib
from importlib.metadata import version
from pathlib import Path

from uvicorn.protocols.http.h11_impl import H11Protocol

PROJECT = tomllib.loads(Path(__file__).parents[3].joinpath("pyproject.toml").read_text("utf-8"))

WHAT_TO_DO = """
uvicorn has moved. Connection in src/lockprobe/foundation/http_server/connections.py extends its H11Protocol, so:
1. Read what changed in uvicorn/protocols/http/h11_impl.py since the version named here.
2. Run tests/foundation/http_server and tests/people/web with the new version.
3. Mend Connection, then raise the bounds of uvicorn in pyproject.toml (extra web) and USED below.
"""

USED = {
    "__init__": "(self, config, server_state, app_state, _loop)",
    "connection_made": "(self, transport)",
    "connection_lost": "(self, exc)",
    "data_received": "(self, data)",
    "on_response_complete": "(self)",
    "pause_writing": "(self)",
    "resume_writing": "(self)",
    "send_400_response": "(self, msg)",
}
"""Each method that Connection overrides or calls, with its parameters in uvicorn 0.54."""


def test_the_extra_has_the_tested_version_and_an_upper_bound():
    (wanted,) = [one for one in PROJECT["project"]["optional-dependencies"]["web"] if one.startswith("uvicorn")]
    bounds = re.fullmatch(r"uvicorn>=(\d+)\.(\d+),<(\d+)\.(\d+)", wanted)
    assert bounds, WHAT_TO_DO
    low, high = (tuple(map(int, pair)) for pair in (bounds.groups()[:2], bounds.groups()[2:]))
    assert high == (low[0], low[1] + 1), WHAT_TO_DO
    assert low <= tuple(map(int, version("uvicorn").split(".")[:2])) < high, WHAT_TO_DO


def test_the_methods_are_as_they_were():
    found = {}
    for name in USED:
        parameters = inspect.signature(getattr(H11Protocol, name, lambda: None)).parameters
        found[name] = f"({', '.join(parameters)})"
    assert found == USED, WHAT_TO_DO
