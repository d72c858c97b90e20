"""The plant ``twin?model=FILE``: hostile files are refused, rules are checked, its truth is the symbolic one."""

import os
from contextlib import ExitStack, closing
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from builders import make_trial, write_study
from lockprobe_robot.twin_settings import UserModelSettings
from lockprobe_robot.user_model.mjcf_file import MjcfModel
from lockprobe_robot.user_model.user_model import UserModel, check_model
from mjcf_models import EXAMPLES, ONE, OWN, exported, one_joint, own_box, written
from PIL import Image
from PIL.PngImagePlugin import PngInfo

import lockprobe
from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.families import box
from lockprobe.boxes.solve import space_of
from lockprobe.foundation.errors import BadFile, BadValue, SettingsChanged
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.records.journal import Journal
from lockprobe.trial.protocols import Plant

SPEC = f"twin?model={OWN}"
CALM = UserModelSettings(model=str(OWN), width=160, height=120)
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


def png(width, height, comment=""):
    """A black picture in colour, with a comment that is packed."""
    (info := PngInfo()).add_text("k", comment, zip=True)
    Image.new("RGB", (width, height)).save(file := BytesIO(), "png", pnginfo=info)
    return file.getvalue()


@pytest.fixture
def plant():
    """Makes plants, which are closed in the end."""
    with ExitStack() as stack:

        def made(puzzle=None, settings=CALM):
            rng = np.random.default_rng(0)
            model = UserModel(puzzle or own_box(), labels=("A", "B", "C"), settings=settings, rng=rng)
            return stack.enter_context(closing(model))

        yield made


def refused(path, puzzle, **settings):
    with pytest.raises(BadFile) as error:
        check_model(puzzle, UserModelSettings(model=str(path), **settings))
    assert "\n" not in str(error.value)
    return str(error.value).removeprefix(f"{path}: ")


def asset(words):
    return f"<mujoco><asset>{words}</asset></mujoco>"


ATTACKS = {
    "no XML": ("not xml", "not XML"),
    "torn": ("<mujoco><body></mujoco>", "not XML (mismatched tag: line 1"),
    "no model": ("<robot name='x'/>", "line 1 of box.xml: <robot>, not an MJCF file"),
    "entities": ("<!DOCTYPE m [<!ENTITY a 'b'>]><mujoco>&a;</mujoco>", "a document type, which is refused"),
    **{
        tag: (f"<mujoco>\n<worldbody><{tag}/></worldbody></mujoco>", f"line 2 of box.xml: <{tag}> is refused")
        for tag in ("extension", "plugin", "model", "attach", "replicate", "composite", "flexcomp", "flex", "skin")
    },
    "made mesh": (asset("<mesh builtin='sphere' params='9'/>"), "<mesh builtin> is refused"),
    "wide field": (asset("<hfield nrow='9' ncol='4e4'/>"), "whole numbers up to 999 as nrow and ncol"),
    "many elements": (f"<mujoco><worldbody>{'<site/>' * 5000}</worldbody></mujoco>", "more than 5000 elements"),
    "include above": ("<mujoco><include file='../other.xml'/></mujoco>", "'../other.xml' is not in the folder"),
    "include of the system": ("<mujoco><include file='/etc/passwd'/></mujoco>", "'/etc/passwd' is not in the folder"),
    "include of itself": ("<mujoco><include file='box.xml'/></mujoco>", "'box.xml' is included a second time"),
    "include of a pipe": ("<mujoco><include file='pipe.xml'/></mujoco>", "not a regular file"),
    "link": (asset("<texture file='link.png'/>"), "not in the folder of the model"),
    "meshes above": ("<mujoco><compiler meshdir='..'/><asset><mesh file='a.stl'/></asset></mujoco>", "not in the folder"),
    "another format": (asset("<texture file='a.txt'/>"), "a.txt is refused: a texture is .png"),
    "a file elsewhere": ("<mujoco><custom><text name='a' file='b'/></custom></mujoco>", "<text file> is refused"),
    "a gone mesh": (asset("<mesh file='gone.stl'/>"), "gone.stl: cannot be read"),
    "torn mesh": (asset("<mesh name='m' file='torn.stl'/>") , "stl_decoder"),
    "wide picture": (asset("<texture type='2d' file='wide.png'/>"), "a picture of 4097 x 1 pixels; at most 4096"),
    "picture that unpacks": (asset("<texture type='2d' file='bomb.png'/>"), "no whole PNG or JPEG picture"),
    "no picture": (asset("<texture type='2d' file='gif.png'/>"), "no whole PNG or JPEG picture"),
    "made picture": (asset("<texture name='t' type='2d' builtin='flat' width='99999' height='1'/>"), "more than 4096 pix"),
    "short steps": ({"head": "<option timestep='1e-9'/>"}, "timestep is 1e-09, expected 0.0002 to 0.01"),
    "long solving": ({"head": "<option iterations='2000000000'/>"}, "iterations is 2e+09, expected 0 to 1000"),
    "much memory": ({"head": "<size njmax='10000'/>"}, "memory in bytes is"),
    "fine shapes": ({"head": "<visual><quality numslices='100000'/></visual>"}, "numslices is 100000"),
    "many joints": ({"outside": f"<body>{'<joint/>' * 3}<geom size='1'/></body>" * 70}, "degrees of freedom is 211"),
    "many lights": ({"outside": "<light/>" * 101}, "lights is 101"),
    "no number": ({"inside": "<geom size='nan'/>"}, "nan size in geom"),
    "no such mesh": ({"inside": "<geom type='mesh' mesh='gone'/>"}, "gone"),
    "another lens": ({"outside": "<camera name='lockprobe' projection='orthographic'/>"}, "'lockprobe' is orthographic"),
}  # fmt: skip


@pytest.mark.parametrize(("given", "why"), ATTACKS.values(), ids=ATTACKS)
def test_what_is_hostile_broken_or_would_take_hours_is_one_line(tmp_path, given, why):
    folder = tmp_path / "in"
    folder.mkdir()
    (tmp_path / "secret.png").write_bytes(png(1, 1))
    (folder / "link.png").symlink_to(tmp_path / "secret.png")
    os.mkfifo(folder / "pipe.xml")
    files = {"wide.png": png(4097, 1), "bomb.png": png(3, 2, "\0" * (1 << 22)), "gif.png": b"GIF89a" + bytes(99)}
    for name, content in (files | {"torn.stl": bytes(90)}).items():
        (folder / name).write_bytes(content)
    with pytest.raises(BadFile) as caught:
        MjcfModel(written(folder, **(given if isinstance(given, dict) else {"text": given}))).compile()
    assert why in str(caught.value)
    assert "\n" not in str(caught.value)


def test_parts_and_meshes_are_read_from_the_folder_and_are_in_the_digest(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "wedge.obj").write_text(TETRAHEDRON)
    (tmp_path / "red.png").write_bytes(png(2, 3))
    (tmp_path / "more.xml").write_text(
        "<mujocoinclude><asset><mesh file='wedge.obj' content_type='model/stl'/><texture name='t' type='2d' file='red.png'/>"
        "</asset></mujocoinclude>",
        "utf-8",
    )
    head = "<include file='more.xml'/><compiler meshdir='parts'/>"
    path = written(tmp_path, head=head, inside="<geom type='mesh' mesh='wedge'/>")
    found = MjcfModel(path)
    model = found.compile()
    assert (model.nmesh, model.mesh(0).name, model.ntex, model.tex_width[0]) == (1, "wedge", 1, 2)
    (tmp_path / "parts" / "wedge.obj").write_text(TETRAHEDRON + "\n")
    assert MjcfModel(path).digest != found.digest
    (tmp_path / "red.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    with pytest.raises(BadFile, match="no whole PNG"):
        MjcfModel(path)


WRONG_JOINTS = {
    "another name": ('name="bolt"', 'name="belt"', "got \"'belt'\", expected one called 'bolt'"),
    "another type": ('type="slide"', 'type="hinge"', 'type="slide", since it is prismatic'),
    "no range": ('range="0 0.1"', "", "got 'no range', expected a limited range"),
    "free": ("</worldbody>", '<body><freejoint name="loose"/><geom size="1"/></body></worldbody>', "free joint"),
    "stops half way": ("</worldbody>", '<geom type="box" size=".01 .1 .1" pos=".08 0 0"/></worldbody>', "less friction"),
    "falls back": ("<joint ", '<joint stiffness="100" ', "the rules let it move, and the model held bolt"),
    "does not rest": ('axis="1 0 0"', 'axis="0 0 -1"', "does not rest in the initial configuration 0: bolt 1.0"),
    "explodes": ("<joint ", '<joint stiffness="-1e13" springref="0.05" ', "became unstable"),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "why"), WRONG_JOINTS.values(), ids=WRONG_JOINTS)
def test_joints_that_a_box_cannot_have_are_refused(tmp_path, monkeypatch, old, new, why):
    monkeypatch.chdir(tmp_path)
    path = written(tmp_path)
    path.write_text(path.read_text("utf-8").replace(old, new), "utf-8")
    assert why in refused(path, one_joint())
    assert list(tmp_path.iterdir()) == [path], "MuJoCo leaves no log of warnings"


def test_a_lock_that_gives_too_far_is_to_be_closed(tmp_path):
    pin = ONE.split("<body>")[1].split("{inside}")[0].replace("bolt", "pin")
    stop = '<geom type="box" size=".01 .1 .1" pos=".08 0 0"/>'
    path = written(tmp_path, outside=f'{stop}<body pos="0 1 0">{pin}</body>')
    joints = tuple(Joint(name=name, kind="prismatic") for name in ("bolt", "pin"))
    lock = {"bolt": ({"pin": True},)}
    two = Lockbox(name="two", joints=joints, interlock=lock, initial=(False, False), target="bolt")
    said = "the rules lock it, and bolt moves 50% of its travel before something holds it (bolt 0.50, pin 0.00): close"
    assert said in refused(path, two)


def test_a_push_leads_from_end_to_end_wherever_the_range_lies_if_it_is_strong_enough(tmp_path):
    path = written(tmp_path)
    path.write_text(path.read_text("utf-8").replace('range="0 0.1"', 'range="-0.3 -0.1"'), "utf-8")
    assert "the rules let it move, and the model held bolt" in refused(path, one_joint(), force=0.5)
    assert check_model(one_joint(), UserModelSettings(model=str(path), force=2.0)) == 1  # against a friction of 1 N


@pytest.mark.parametrize("name", ["bichain-3", "common-effect-3"])
def test_our_own_scenes_read_back_as_users_models_obey_their_rules_everywhere(tmp_path, name):
    found = check_model(box(name), UserModelSettings(model=str(exported(box(name), tmp_path))))
    assert found == len(space_of(box(name)).reachable)


def test_a_rule_changed_in_either_direction_is_found_and_said_as_the_page_says_it():
    puzzle = own_box()
    locked = replace(puzzle, interlock={**puzzle.interlock, "pin": ({"bar": True},)})
    assert refused(OWN, locked) == (
        "in configuration 000 (door, bar, pin), pin was pushed: the rules lock it, and the model moved pin "
        "(door 0.00, bar 0.00, pin 1.00)"
    )
    said = refused(OWN, replace(puzzle, interlock={**puzzle.interlock, "pin": ({},)}))
    assert f"\nlockprobe: own_box.xml: {said}\n" in (EXAMPLES.parent / "docs" / "boxes.md").read_text("utf-8")


def test_its_truth_is_the_symbolic_one_also_of_a_box_that_was_dealt(plant):
    puzzle = own_box()
    physical, symbolic = plant(puzzle), SymbolicPlant(puzzle)
    assert isinstance(physical, Plant)
    for joint in np.random.default_rng(1).integers(1, 3, size=12):  # not the door, whose motion ends a trial
        seen, ruled = physical.attempt(int(joint)), symbolic.attempt(int(joint))
        assert (seen.configuration, seen.joint, seen.outcome) == (ruled.configuration, ruled.joint, ruled.outcome)
    options = {"box": str(EXAMPLES / "own_box.toml"), "agent": "human-inspired", "p": 0.4, "seed": 5}
    assert lockprobe.run_trial(plant=SPEC, **options).steps == lockprobe.run_trial(plant="symbolic", **options).steps
    dealt = plant(replace(puzzle, joints=puzzle.joints[::-1]))
    assert [dealt.attempt(joint).outcome for joint in (0, 2)] == ["moved", "blocked"]


def test_pictures_show_the_moment_what_is_told_and_the_labels(plant):
    physical = plant()
    before = physical.observe()
    first, told = before.look(), before.render((False, False, True))
    second = physical.attempt(2).look()
    assert first.rgb.shape == (120, 160, 3)
    assert (first.rgb != second.rgb).any()
    assert (told.rgb == second.rgb).mean() > 0.99
    bare = plant(settings=replace(CALM, labels=False)).observe().look()
    rows, columns = np.nonzero((bare.rgb != first.rgb).any(2))
    assert 20 < len(rows) < 1000
    assert (bare.labelled, first.labelled) == (False, True)
    places = first.camera.project(first.handles)[..., :2]
    assert np.abs(columns[:, None] - places[:, 0, 0]).min(1).max() < 40


def test_without_a_panel_sites_and_a_camera_the_world_the_parts_and_a_view_stand_in(tmp_path, plant):
    lines = OWN.read_text("utf-8").splitlines()
    text = "\n".join(line for line in lines if not any(word in line for word in ("<site", "<camera")))
    path = written(tmp_path, text.replace('body name="panel"', 'body name="table"'))
    frame = plant(settings=replace(CALM, model=str(path))).observe().look()
    assert frame.handles[1, 1] - frame.handles[1, 0] == pytest.approx([0.08, 0, 0], abs=1e-6)
    assert 0 < frame.handles[1, 0, 2] < 0.012  # the bar's centre of mass, in the world
    places = frame.camera.project(frame.handles)[..., :2]
    assert ((places > 0) & (places < (160, 120))).all()
    assert frame.rgb.std() > 5


def test_its_panel_is_never_dealt_anew():
    """Else words would tell places where the joints of the model do not lie."""
    asked = {"plant": SPEC, "box": own_box(), "modality": "symbolic?places=yes"}
    assert lockprobe.study("modalities", **asked).layout == "fixed"
    with pytest.raises(BadValue, match=r"^layout: got 'dealt', expected fixed with twin\?model=.*stay where"):
        lockprobe.study("modalities", layout="dealt", **asked)


def test_a_study_does_not_go_on_with_another_model(tmp_path):
    options = {"agent": "random", "box": str(EXAMPLES / "own_box.toml"), "repetitions": 1, "trials": 1, "p": [0.0]}
    path = written(tmp_path, OWN.read_text("utf-8"))
    planned = lockprobe.study("flips", plant=f"twin?model={path}", **options)
    write_study(tmp_path / "S", planned, [make_trial([0], study="flips")])
    with Journal.open(tmp_path / "S", lockprobe.study("flips", plant=f"twin?model={path}", **options)):
        pass
    path.write_text(OWN.read_text("utf-8").replace("0.62", "0.6"), "utf-8")
    changed = lockprobe.study("flips", plant=f"twin?model={path}", **options)
    with pytest.raises(SettingsChanged, match=r"plant is 'twin\?model=.*digest="):
        Journal.open(tmp_path / "S", changed).__enter__()
    with pytest.raises(BadFile, match="another model: its digest is [0-9a-f]{16}, [0-9a-f]{16} was asked for"):
        resolve_plant(planned.plant).check(planned.box)
    path.unlink()
    assert resolve_plant(planned.plant).has_camera  # what was played can be read without the model
