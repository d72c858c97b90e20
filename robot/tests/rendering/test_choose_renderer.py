"""What works is found out in other processes, and a machine without any graphics library still gets pictures."""

import functools
import json
import os
import subprocess
import sys

import pytest
from lockprobe_robot.rendering import choose_renderer
from lockprobe_robot.rendering.choose_renderer import Probed, decide, probe

from lockprobe.foundation.errors import BadValue, Missing

NO_GRAPHICS = """
import ctypes, ctypes.util
real_find, real_load = ctypes.util.find_library, ctypes.CDLL.__init__
graphics = lambda name: any(part in str(name) for part in ("GL", "OSMesa"))
ctypes.util.find_library = lambda name: None if graphics(name) else real_find(name)
def load(self, name, *args, **options):
    if graphics(name):
        raise OSError(f"{name}: cannot open shared object file")
    real_load(self, name, *args, **options)
ctypes.CDLL.__init__ = load
"""

LOOKS = """
import json, os, sys
import lockprobe
assert "mujoco" not in sys.modules
from lockprobe_robot.rendering.choose_renderer import decide, probe
import mujoco
from lockprobe_robot.rendering.choose_renderer import open_renderer
world = "<worldbody><geom size='1'/><camera name='eye' pos='0 0 3'/></worldbody>"
model = mujoco.MjModel.from_xml_string(f"<mujoco>{world}</mujoco>")
renderer = open_renderer(model, width=64, height=64)
rgb, depth = renderer.render(mujoco.MjData(model), "eye")
print(json.dumps([decide(), renderer.name, float(depth[32, 32]), [one.detail for one in probe()],
                  os.environ.get("MUJOCO_GL")]))
"""


def python(program, **environment):
    """What a program prints, in a process of its own."""
    kept = {name: value for name, value in os.environ.items() if name not in ("MUJOCO_GL", choose_renderer.VARIABLE)}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", program],
        capture_output=True,
        text=True,
        env=kept | environment,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture
def works(monkeypatch):
    """Says which renderers work; nothing is tried."""

    def say(*names):
        found = {name: Probed(name=name, ok=name in names, detail="" if name in names else "broken")
                 for name in choose_renderer.RENDERERS}  # fmt: skip
        monkeypatch.setattr(choose_renderer, "probe_one", found.__getitem__)
        monkeypatch.delenv(choose_renderer.VARIABLE, raising=False)

    return say


def test_without_any_graphics_library_rays_are_cast(tmp_path):
    (tmp_path / "sitecustomize.py").write_text(NO_GRAPHICS)
    taken, name, depth, details, platform = json.loads(python(LOOKS, PYTHONPATH=str(tmp_path)))
    assert taken == "rays"
    assert name.startswith("rays (mujoco")
    assert depth == pytest.approx(2, abs=0.001)
    assert details == ["no libEGL on this machine", "no libOSMesa on this machine", ""]
    assert platform is None


def test_importing_and_naming_plants_touches_neither_mujoco_nor_graphics():
    modules = [
        "lockprobe",
        "lockprobe.cli",
        "lockprobe.cli.doctor",
        "lockprobe.interventions.camera",
        "lockprobe.trial.pictures.depth",
        "lockprobe.trial.pictures.png",
        "lockprobe_robot.rendering.choose_renderer",
        "lockprobe.plants.catalogue as plants",
    ]
    program = "; ".join(f"import {module}" for module in modules)
    program += "; [plants.resolve_plant(name) for name in plants.PLANTS]"
    program += "; import sys; print([name for name in ('mujoco', 'OpenGL', 'glfw', 'PIL') if name in sys.modules])"
    assert python(program).strip() == "[]"


def test_the_first_that_works_is_taken(works):
    for names, taken in ((("egl", "rays"), "egl"), (("osmesa", "rays"), "osmesa"), (("rays",), "rays")):
        works(*names)
        assert decide() == decide("auto") == taken


def test_the_environment_variable_stands_for_auto_only(works, monkeypatch):
    works("egl", "rays")
    monkeypatch.setenv("LOCKPROBE_RENDERER", "rays")
    assert decide("auto") == "rays"
    assert decide("egl") == "egl"
    monkeypatch.setenv("LOCKPROBE_RENDERER", "auto")
    assert decide("auto") == "egl"
    monkeypatch.setenv("LOCKPROBE_RENDERER", "metal")
    with pytest.raises(BadValue, match="LOCKPROBE_RENDERER: got 'metal', expected one of auto, egl, osmesa, rays"):
        decide("auto")


def test_what_does_not_work_is_refused_with_the_reason_and_the_remedy(works):
    works("rays")
    with pytest.raises(Missing, match=r"renderer egl does not work here \(broken\): install libEGL .* renderer=rays"):
        decide("egl")
    works()
    with pytest.raises(Missing, match=r"renderer rays does not work here \(broken\): pip install"):
        decide("auto")


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
def test_whatever_happens_while_one_is_tried_is_told(program, detail, monkeypatch):
    monkeypatch.setattr(choose_renderer, "_PROBE", program)
    monkeypatch.setattr(choose_renderer, "_TIMEOUT", 1.0 if "sleep" in program else 60.0)
    monkeypatch.setattr(choose_renderer, "probe_one", functools.cache(choose_renderer.probe_one.__wrapped__))
    probed = choose_renderer.probe_one("rays")
    assert (probed.ok, probed.detail) == (program.startswith("print"), detail)


def test_all_are_told_in_the_order_in_which_they_are_tried():
    probed = probe()
    assert [one.name for one in probed] == ["egl", "osmesa", "rays"]
    assert probed[-1].ok
    assert all(one.ok or one.detail for one in probed)
