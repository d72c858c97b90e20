"""What works is found out in another process, and a machine without a graphics library is told what to install."""

import functools
import os
import subprocess
import sys

import pytest
from lockprobe_robot.rendering import probe as module

from lockprobe.foundation.errors import Missing

NO_GRAPHICS = """
import ctypes, ctypes.util
real_find, real_load = ctypes.util.find_library, ctypes.CDLL.__init__
graphics = lambda name: "GL" in str(name)
ctypes.util.find_library = lambda name: None if graphics(name) else real_find(name)
def load(self, name, *args, **options):
    if graphics(name):
        raise OSError(f"{name}: cannot open shared object file")
    real_load(self, name, *args, **options)
ctypes.CDLL.__init__ = load
"""

LOOKS = """
import sys
import lockprobe
from lockprobe_robot.rendering.probe import require_opengl
from lockprobe.foundation.errors import Missing
try:
    require_opengl()
except Missing as missing:
    print(missing)
assert "mujoco" not in sys.modules
"""


def python(program, **environment):
    """What a program prints, in a process of its own."""
    kept = {name: value for name, value in os.environ.items() if name != "MUJOCO_GL"}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", program],
        capture_output=True,
        text=True,
        env=kept | environment,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_without_any_graphics_library_one_line_says_what_to_install(tmp_path):
    (tmp_path / "sitecustomize.py").write_text(NO_GRAPHICS)
    said = python(LOOKS, PYTHONPATH=str(tmp_path))
    assert said.startswith("pictures need OpenGL, which does not work here (no libEGL on this machine): install ")
    assert "Debian: libegl1 libopengl0 libegl-mesa0 libgl1-mesa-dri" in said
    assert said.count("\n") == 1


def test_importing_and_naming_plants_touches_neither_mujoco_nor_graphics():
    modules = [
        "lockprobe",
        "lockprobe.cli",
        "lockprobe.cli.doctor",
        "lockprobe.interventions.camera",
        "lockprobe.trial.pictures.depth",
        "lockprobe.trial.pictures.png",
        "lockprobe_robot.rendering.probe",
        "lockprobe.plants.catalogue as plants",
    ]
    program = "; ".join(f"import {module}" for module in modules)
    program += "; [plants.resolve_plant(name) for name in plants.PLANTS]"
    program += "; import sys; print([name for name in ('mujoco', 'OpenGL', 'glfw', 'PIL') if name in sys.modules])"
    assert python(program).strip() == "[]"


@pytest.mark.parametrize(
    ("program", "detail"),
    [
        ("import os; os.abort()", "it ended with SIGABRT"),
        ("raise SystemExit(7)", "exit status 7"),
        ("raise OSError('no screen')", "OSError: no screen"),
        ("import time; time.sleep(60)", "it hung for 1 s"),
        ("print('a driver')", "a driver"),
    ],
)
def test_whatever_happens_while_it_is_tried_is_told(program, detail, monkeypatch):
    monkeypatch.setattr(module, "_PROBE", program)
    monkeypatch.setattr(module, "_TIMEOUT", 1.0 if "sleep" in program else 60.0)
    monkeypatch.setattr(module, "probe", functools.cache(module.probe.__wrapped__))
    assert (module.probe().ok, module.probe().detail) == (program.startswith("print"), detail)


def test_what_does_not_work_is_refused_with_the_reason_and_the_remedy(monkeypatch):
    monkeypatch.setattr(module, "probe", lambda: module.Probed(ok=False, detail="broken"))
    with pytest.raises(Missing, match=r"does not work here \(broken\): install libEGL"):
        module.renderer_name()
