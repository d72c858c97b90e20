"""A user's model is read with limits; whatever is wrong with it is one line."""

import os

import pytest
from lockprobe_robot.user_model import mjcf_file
from lockprobe_robot.user_model.mjcf_file import read_model
from mjcf_models import OWN, written
from painted_png import png

from lockprobe.foundation.errors import BadFile, BadValue

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


def test_the_text_for_mujoco_is_the_tags_in_order_and_its_lines_lead_back():
    found = read_model(OWN)
    lines = found.text.splitlines()
    assert lines[0] == '<mujoco model="own-box">'
    assert lines[-1] == "</mujoco>"
    assert len(found.origins) == len(lines)
    source = OWN.read_text("utf-8").splitlines()
    at = next(number for number, line in enumerate(lines, 1) if line.startswith('<body name="bar"'))
    said = found.explain(f"Element 'body', line {at}")
    assert source[int(said.rsplit(" ", 1)[1]) - 1].strip() == '<body name="bar">'
    assert found.parts_sha256 == ""


def test_what_is_included_and_referred_to_is_read_from_the_folder_and_is_in_the_checksum(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "wedge.obj").write_text(TETRAHEDRON)
    (tmp_path / "more.xml").write_text(
        '<mujocoinclude><asset>\n<mesh file="wedge.obj"/></asset></mujocoinclude>', "utf-8"
    )
    path = written(tmp_path, '<mujoco><include file="more.xml"/><compiler meshdir="parts"/><worldbody/></mujoco>')
    found = read_model(path)
    assert '<mesh file="asset-1.obj" name="wedge">' in found.text
    assert found.assets == {"asset-1.obj": TETRAHEDRON.encode()}
    assert "include" not in found.text
    assert "meshdir" not in found.text
    at = found.text.splitlines().index('<mesh file="asset-1.obj" name="wedge">') + 1
    assert found.explain(f"line {at}") == "line 2 of more.xml"
    before = found.parts_sha256
    (tmp_path / "parts" / "wedge.obj").write_text(TETRAHEDRON + "\n")
    after = read_model(path)
    assert (after.sha256, after.parts_sha256 != before) == (found.sha256, True)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "not XML"),
        ("not xml", "not XML"),
        ("<mujoco><body></mujoco>", "not XML (mismatched tag: line 1"),
        ("<robot name='x'/>", "line 1: <robot>, not an MJCF file"),
        ("<!DOCTYPE m [<!ENTITY a 'b'>]><mujoco>&a;</mujoco>", "line 1: a document type, which is refused"),
        ("<mujoco>\n<extension><plugin plugin='x'/></extension></mujoco>", "line 2: <extension> is refused: a plugin"),
        ("<mujoco><worldbody><plugin plugin='x'/></worldbody></mujoco>", "<plugin> is refused"),
        ("<mujoco><asset><model name='x' file='y.xml'/></asset></mujoco>", "<model> is refused: include the file"),
        ("<mujoco><worldbody><replicate count='1000000'/></worldbody></mujoco>", "<replicate> is refused"),
        ("<mujoco><worldbody><composite count='9 9 9'/></worldbody></mujoco>", "<composite> is refused"),
        ("<mujoco><asset><mesh builtin='sphere' params='9'/></asset></mujoco>", "<mesh builtin> is refused"),
        ("<mujoco><asset><hfield nrow='-1' ncol='1'/></asset></mujoco>", "nrow is '-1', expected a whole number"),
        (
            "<mujoco><asset><hfield nrow='1000' ncol='1'/></asset></mujoco>",
            "nrow is '1000', expected a whole number up to",
        ),
        ("<mujoco><asset><hfield nrow='9' ncol='4e4'/></asset></mujoco>", "ncol is '4e4', expected a whole number"),
        ("<mujoco><include file='../other.xml'/></mujoco>", "'../other.xml' is not in the folder of the model"),
        ("<mujoco><include file='/etc/passwd'/></mujoco>", "'/etc/passwd' is not in the folder of the model"),
        ("<mujoco><include file='box.xml'/></mujoco>", "'box.xml' is included a second time"),
        ("<mujoco><include file='gone.xml'/></mujoco>", "gone.xml: cannot be read"),
        ("<mujoco><include/></mujoco>", "a directory, not a regular file"),
        ("<mujoco><compiler meshdir='..'/><asset><mesh file='a.stl'/></asset></mujoco>", "not in the folder"),
        ("<mujoco><asset><texture file='/etc/hostname'/></asset></mujoco>", "not in the folder of the model"),
        ("<mujoco><asset><texture file='a.txt'/></asset></mujoco>", "a.txt is refused: a texture is .png"),
        ("<mujoco><asset><mesh file='gone.stl'/></asset></mujoco>", "gone.stl: cannot be read"),
        ("<mujoco><custom><text name='a' file='b'/></custom></mujoco>", "<text file> is refused"),
    ],
)
def test_what_is_hostile_or_broken_is_one_line(tmp_path, text, why):
    with pytest.raises(BadFile) as refused:
        read_model(written(tmp_path, text or " "))
    assert why in str(refused.value)
    assert "\n" not in str(refused.value)


def test_links_out_of_the_folder_pipes_and_chains_of_includes_are_refused(tmp_path):
    inside = tmp_path / "in"
    inside.mkdir()
    (tmp_path / "secret.png").write_bytes(png(1, 1))
    (inside / "link.png").symlink_to(tmp_path / "secret.png")
    with pytest.raises(BadFile, match="not in the folder of the model"):
        read_model(written(inside, "<mujoco><asset><texture file='link.png'/></asset></mujoco>"))
    os.mkfifo(inside / "pipe.xml")
    with pytest.raises(BadFile, match="a pipe"):
        read_model(written(inside, "<mujoco><include file='pipe.xml'/></mujoco>"))
    for i in range(60):
        (inside / f"{i}.xml").write_text(f"<mujoco><include file='{i + 1}.xml'/></mujoco>", "utf-8")
    with pytest.raises(BadFile, match="more than 50 files are included"):
        read_model(written(inside, "<mujoco><include file='0.xml'/></mujoco>"))


def test_sizes_are_limited_in_all(tmp_path, monkeypatch):
    monkeypatch.setattr(mjcf_file, "LARGEST_XML", 100)
    with pytest.raises(BadFile, match="larger than 100 bytes"):
        read_model(written(tmp_path, f"<mujoco>{' ' * 100}</mujoco>"))
    (tmp_path / "half.xml").write_text(f"<mujoco>{' ' * 60}</mujoco>", "utf-8")
    with pytest.raises(BadFile, match=r"half.xml: larger than 5\d bytes"):
        read_model(written(tmp_path, "<mujoco><include file='half.xml'/></mujoco>"))
    monkeypatch.setattr(mjcf_file, "LARGEST_ASSETS", 100)
    for name in "ab":
        (tmp_path / f"{name}.png").write_bytes(png(4, 4))
    with pytest.raises(BadFile, match="b.png: larger than"):
        read_model(written(tmp_path, "<mujoco><x file='a'/></mujoco>".replace("<x file='a'/>", _two("a", "b"))))


def _two(*names):
    return "<asset>" + "".join(f"<texture file='{name}.png'/>" for name in names) + "</asset>"


COLLECTION = "<mujoco><compiler meshdir='../assets'/><asset><mesh file='a.obj'/></asset><worldbody/></mujoco>"


@pytest.fixture
def collection(tmp_path):
    """A collection of models with their meshes in a sibling folder."""
    for folder in ("assets", "boxes"):
        (tmp_path / folder).mkdir()
    (tmp_path / "assets" / "a.obj").write_text(TETRAHEDRON)
    return tmp_path


def test_files_of_a_sibling_folder_are_refused_with_the_way_out(collection):
    path = written(collection / "boxes", COLLECTION)
    with pytest.raises(BadFile) as refused:
        read_model(path)
    assert f"; add &root={collection} to the plant to read files of that folder" in str(refused.value)
    found = read_model(path, collection)
    assert found.names == {"asset-0.obj": "../assets/a.obj"}
    digest = found.digest
    (collection / "assets" / "a.obj").write_text(TETRAHEDRON + "\n")
    assert read_model(path, collection).digest != digest


def test_a_root_holds_the_model_and_nothing_beyond_it_is_read(collection):
    path = written(collection / "boxes", COLLECTION)
    with pytest.raises(BadValue, match="root: got .*assets', expected a folder that holds .*box.xml and its files"):
        read_model(path, collection / "assets")
    outside = written(collection / "boxes", COLLECTION.replace("../assets", "/etc"))
    with pytest.raises(BadFile, match=r"'/etc/a.obj' is not in .*[^d]$"):
        read_model(outside, collection)


def test_the_suffix_says_the_format_whatever_the_model_says(tmp_path):
    (tmp_path / "a.obj").write_text(TETRAHEDRON)
    head = "<asset><mesh file='a.obj' content_type='model/stl'/></asset>"
    assert "content_type" not in read_model(written(tmp_path, f"<mujoco>{head}</mujoco>")).text
