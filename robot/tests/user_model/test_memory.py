"""No model takes more memory than the limit, whatever asks for it, and the sum is at least what is taken."""

import struct
import subprocess
import sys
from pathlib import Path

import mujoco
import pytest
from lockprobe_robot.user_model.compiled_model import compile_model
from lockprobe_robot.user_model.memory import LARGEST_MEMORY, parts_of
from lockprobe_robot.user_model.mjcf_file import read_model
from mjcf_models import OWN, written
from painted_png import png

from lockprobe.foundation.errors import BadFile

BIG = "width='4096' height='4096'"
TEXTURE = f"<texture name='t{{i}}' type='{{kind}}' builtin='flat' {BIG}/>"
GEOM = "<geom name='g' size='.1' pos='9 9 9'/>"


def repeated(text, number, **fields):
    return "".join(text.format(i=i, **fields) for i in range(number))


def asset(content):
    return f"<asset>{content}</asset>"


def with_classes(number):
    return f"<default>{repeated('<default class=`c{i}`/>', number)}</default>".replace("`", "'")


ARENA = "stack, contacts and constraints"

HOSTILE = {
    "flat textures": ("textures", {"head": asset(repeated(TEXTURE, 60, kind="2d"))}),
    "cubes": ("textures", {"head": asset(repeated(TEXTURE, 5, kind="cube"))}),
    "skyboxes": ("textures", {"head": asset(repeated(TEXTURE, 3, kind="skybox"))}),
    "sizes of a class": (
        "textures",
        {
            "head": f"<default><default class='q'><texture {BIG} builtin='flat' type='skybox'/></default></default>"
            + asset(repeated("<texture name='t{i}' class='q'/>", 4))
        },
    ),
    "one picture many times": (
        "textures",
        {"head": asset(repeated("<texture name='t{i}' type='2d' file='wide.png'/>", 40))},
    ),
    "pictures of six sides": (
        "textures",
        {"head": asset(repeated("<texture name='t{i}' type='cube' fileright='wide.png' fileleft='wide.png'/>", 20))},
    ),
    "height fields": (
        "height fields",
        {"head": asset("<hfield name='h' nrow='40000' ncol='40000' size='1 1 1 1'/>")},
    ),
    "pictures of height fields": (
        "height fields",
        {"head": asset(repeated("<hfield name='h{i}' file='wide.png' size='1 1 1 1'/>", 9))},
    ),
    "one mesh many times": ("meshes", {"head": asset(repeated("<mesh name='m{i}' file='m.stl'/>", 500))}),
    "a face of many corners": ("meshes", {"head": asset(repeated("<mesh name='m{i}' file='fan.obj'/>", 50))}),
    "user sensors": ("sensors", {"outside": "</worldbody><sensor><user dim='200000000'/></sensor><worldbody>"}),
    "histories of sensors": (
        "sensors",
        {"outside": "</worldbody><sensor><clock nsample='16000000' delay='1'/></sensor><worldbody>"},
    ),
    "contacts of sensors": (
        "sensors",
        {"outside": f"{GEOM}</worldbody><sensor><contact num='9000000' geom1='g'/></sensor><worldbody>"},
    ),
    "cameras of sensors": (
        "sensors",
        {
            "outside": "<camera name='c' resolution='20000 20000'/></worldbody>"
            "<sensor><rangefinder camera='c'/></sensor><worldbody>"
        },
    ),
    "activations": (
        "actuators",
        {
            "outside": "</worldbody><actuator><general joint='bolt' actdim='90000000' dyntype='user'/></actuator>"
            "<worldbody>"
        },
    ),
    "histories of actuators": (
        "actuators",
        {"outside": "</worldbody><actuator><motor joint='bolt' nsample='90000000' delay='1'/></actuator><worldbody>"},
    ),
    "keyframes": (
        "keyframes",
        {"head": "<size nkey='900000'/>", "outside": "<body mocap='true'/>" * 50},
    ),
    "numbers of users": ("user data", {"head": "<size nuserdata='200000000'/>"}),
    "numbers of sites": ("user data", {"head": "<size nuser_site='100000'/>", "outside": "<site/>" * 1000}),
    "memory": (ARENA, {"head": "<size memory='3G'/>"}),
    "stack": (ARENA, {"head": "<size nstack='900000000'/>"}),
    "contacts": (ARENA, {"head": "<size nconmax='2000000'/>"}),
    "constraints": (ARENA, {"head": "<size njmax='20000'/>"}),
    "constraints on a small stack": (ARENA, {"head": "<size njmax='20000' nstack='1000'/>"}),
    "signed distance fields": (
        "signed distance fields",
        {
            "head": asset(
                repeated("<mesh name='m{i}' vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 2 1 0 1 3 1 2 3 0 3 2'/>", 90)
            ),
            "outside": repeated("<geom type='sdf' mesh='m{i}' pos='9 9 {i}'/>", 90),
        },
    ),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files that models here name."""
    folder = tmp_path_factory.mktemp("models")
    (folder / "wide.png").write_bytes(png(4096, 4096))
    (folder / "m.stl").write_bytes(bytes(80) + struct.pack("<I", 3000) + bytes(50 * 3000))
    (folder / "fan.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + " 1 2 3" * 10_000 + "\n")
    return folder


@pytest.mark.parametrize("name", HOSTILE)
def test_a_small_file_cannot_take_all_memory(folder, name, monkeypatch):
    largest, parts = HOSTILE[name]

    def compiled(_):
        raise AssertionError("it was compiled")

    monkeypatch.setattr(mujoco.MjSpec, "compile", compiled)
    with pytest.raises(
        BadFile, match=rf"it would take [\d.]+ [MG]B of memory, .* the largest part is .* for {largest}"
    ):
        compile_model(read_model(written(folder, **parts)))


@pytest.mark.parametrize("joints", [0, 20, 190])
@pytest.mark.parametrize(
    "sizes",
    ["", "nconmax='0'", "nconmax='300000'", "njmax='0'", "njmax='3000'", "nstack='0' njmax='8000'", "nstack='9000000'",
     "nconmax='200000' njmax='2000'", "nstack='1000' nconmax='100000' njmax='50'", "memory='5M'"],
)  # fmt: skip
def test_the_sum_holds_the_arena_of_every_size(tmp_path, sizes, joints):
    moving = "<body pos='9 9 9'><joint type='slide'/><geom size='.01'/></body>" * joints
    file = read_model(written(tmp_path, head=f"<size {sizes}/>" if sizes else "", outside=moving))
    spec = mujoco.MjSpec.from_string(file.text, assets=dict(file.assets))
    (arena,) = [part.size for part in parts_of(spec, file) if part.what.startswith(ARENA)]
    assert spec.compile().narena <= arena <= LARGEST_MEMORY


@pytest.mark.parametrize(
    ("parts", "why"),
    [
        ({"outside": "<site/>" * 10_001}, "elements, expected at most 10000"),
        ({"head": with_classes(10_001)}, "elements, expected at most 10000"),
        ({"outside": "<light/>" * 101}, "101 lights, expected at most 100"),
        ({"head": asset(repeated("<material name='m{i}'/>", 1001))}, "materials is 1001"),
        ({"outside": f"<body>{'<joint/>' * 3}<geom size='1'/></body>" * 70}, "211 degrees of freedom"),
    ],
)
def test_many_elements_are_refused(tmp_path, parts, why):
    with pytest.raises(BadFile, match=why):
        compile_model(read_model(written(tmp_path, **parts)))


PEAK = """
import os, re, sys
from pathlib import Path
import numpy as np
from lockprobe.boxes.boxfile import read_box
from lockprobe_robot.twin_settings import UserModelSettings
from lockprobe_robot.user_model.user_model import UserModel

def peak(model):
    plant = UserModel(
        box, labels=box.names, settings=UserModelSettings(model=model, renderer="rays"), rng=np.random.default_rng(1)
    )
    plant.observe().look()
    status = Path("/proc/self/status").read_text()
    return 1024 * int(re.search(r"VmHWM:\\s*(\\d+) kB", status)[1])

box = read_box(Path(sys.argv[1]))
own, *models = sys.argv[2:]
for model in models:
    if child := os.fork():
        assert os.waitpid(child, 0)[1] == 0
        continue
    plain = peak(own)
    print(peak(model) - plain, flush=True)
    os._exit(0)
"""
"""How much more memory each model takes than the one that ships, in a process for each that has imported all."""

USED = "<material name='m' texture='t0'/>"
SHOWN = "<geom type='box' size='.1 .1 .1' material='m' pos='.1 .1 -.2' contype='0' conaffinity='0'/>"


LARGE = {
    "texture": (asset(TEXTURE.format(i=0, kind="2d") + USED), SHOWN, ""),
    "skybox": (asset(TEXTURE.format(i=0, kind="skybox").replace("4096", "2048")), "", ""),
    "picture": (asset("<texture name='t0' type='2d' file='wide.png'/>" + USED), SHOWN, ""),
    "sensor": ("", "", "<sensor><user dim='5000000'/></sensor>"),
    "history": ("", "", "<sensor><clock nsample='2000000' delay='1' interval='0.01 0'/></sensor>"),
    "classes": (with_classes(4000), "", ""),
    "sites": ("", "<site/>" * 9000, ""),
}
"""What models hold at the head, in the world and at the end."""


@pytest.fixture(scope="module")
def took(folder):
    """Files of these models, and the bytes that each takes more than the one that ships."""
    paths = {}
    for name, (head, inside, tail) in LARGE.items():
        text = OWN.read_text("utf-8").replace("<worldbody>", f"{head}<worldbody>{inside}").replace("</mujoco>", "")
        paths[name] = folder / f"{name}.xml"
        paths[name].write_text(f"{text}{tail}</mujoco>", "utf-8")
    command = [sys.executable, "-c", PEAK, OWN.with_suffix(".toml"), OWN, *paths.values()]
    found = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.split()
    return {name: (paths[name], int(bytes_)) for name, bytes_ in zip(LARGE, found, strict=True)}


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the peak of memory is read from /proc")
@pytest.mark.parametrize("name", LARGE)
def test_no_model_takes_more_than_its_sum(took, name):
    path, bytes_ = took[name]
    file = read_model(path)
    total = sum(part.size for part in parts_of(mujoco.MjSpec.from_string(file.text, assets=dict(file.assets)), file))
    assert bytes_ <= total + (40 << 20)  # what the allocator and the renderer take beside it varies by some
    assert total <= LARGEST_MEMORY
