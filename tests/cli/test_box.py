"""``lockprobe box``, as typed."""

import json
import shutil
from contextlib import redirect_stdout
from functools import partial
from io import BytesIO, TextIOWrapper

import pytest
import strangers
from mjcf_models import EXAMPLES
from typed import in_process

from lockprobe.boxes.boxfile import read_box
from lockprobe.boxes.solve import optimum
from lockprobe.cli import build
from lockprobe.foundation.errors import BadFile, UserMistake

ask = partial(in_process, "box")


def test_a_box_in_words_and_its_facts_as_json():
    facts = json.loads(ask("show", "reset", "--json").stdout)
    assert (facts["optimum"], facts["optimal_plans"], facts["distractors"], facts["initial"]) == (5, 2, [], "0000")
    assert facts["random_no_repeat_success"] == pytest.approx(0.479486, abs=1e-6)
    assert facts["cycle_success"] == pytest.approx(2 / 3)
    said = ask("show", "reset").stdout
    for part in ("reset: 4 joints, target revolute-left, optimum 5 steps, 2 optimal plans", "[#-]", "and revolute-right closed",
                 "random 0.2305, random without repeats 0.4795"):  # fmt: skip
        assert part in said


def test_terminals_that_know_only_ascii_are_spared_the_rest():
    with redirect_stdout(TextIOWrapper(BytesIO(), "ascii")) as shown:
        build(["box"])(["box", "show", "random-8-3"], standalone_mode=False)
    said = shown.buffer.getvalue()
    assert (b"?" in said, b"+----" in said) == (False, True)


@pytest.mark.parametrize(("ending", "start"), [("png", b"\x89PNG"), ("xml", b"<mujoco")])
def test_a_picture_or_a_model(tmp_path, ending, start):
    path = tmp_path / f"box.{ending}"
    assert ask("show", "fork", "--out", path).stdout == f"{path}\n"
    assert path.read_bytes().startswith(start)


def test_generated_files_are_boxes(tmp_path):
    said = ask("generate", "--family", "random-5", "--layout", "zigzag", "--deal", "--count", 3, "--out", tmp_path)
    files = sorted(tmp_path.iterdir())
    assert len(files) == 3
    assert len(said.stdout.splitlines()) == 3
    for file in files:
        found = read_box(file)
        assert f"{file}  optimum {optimum(found)}, random" in said.stdout
        assert json.loads(ask("show", file, "--json").stdout)["name"] == found.name == file.stem
    again = ask("generate", "--family", "random-5", "--layout", "zigzag", "--deal", "--count", 3, "--out", tmp_path)
    assert again.stdout == said.stdout


def test_a_file_of_another_box_is_left_alone(tmp_path):
    ask("generate", "--out", tmp_path, "--seed", 2)
    (file,) = tmp_path.iterdir()
    file.write_text("mine", "utf-8")
    with pytest.raises(BadFile, match="already exists with other content: give another --out"):
        ask("generate", "--out", tmp_path, "--seed", 2)
    assert file.read_text("utf-8") == "mine"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["own_box.xml"], "expected a name or FILE.toml with its rules; a MuJoCo model is a plant: --plant"),
        (["own_box.toml", "none.xml"], "none.xml: cannot be read"),
        (["own_box.toml", "own_box.toml"], "own_box.toml: not XML"),
        (["chain-4", "own_box.xml"], "expected one called 'revolute-left', as in the box"),
        (["own_box.toml", "twin?model="], "cannot be read"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_what_is_wrong_with_a_model_is_one_line(words, message):
    with pytest.raises(UserMistake, match=message) as found:
        ask("check", *words)
    assert "\n" not in str(found.value)


def test_the_list_has_boxes_of_packages_and_why_one_cannot_be_used(tmp_path, monkeypatch):
    strangers.install(tmp_path, monkeypatch, points={"boxes": {"gate": "gate", "stuck": "STUCK", "broken": "breaks"}})
    found = {line["name"]: line for line in map(json.loads, ask("list", "--json").stdout.splitlines())}
    said = {line.split()[0]: " ".join(line.split()) for line in ask("list").stdout.splitlines()}
    assert (found["gate"]["optimum"], found["gate"]["package"]) == (3, "strange-things 0.3")
    assert said["gate"].startswith("gate 3 3 0.743 0.973")
    for name, why in (("stuck", "unsolvable: no sequence of attempts moves gate"), ("broken", "by nothing")):
        assert why in found[name]["error"]
        assert said[name] == f"{name} {found[name]['error']}"
        assert said[name].startswith(f"{name} Cannot be used. ")


HEAD = "own_box.toml: can be played. 3 joints, target door, optimum 3 steps, 3 configurations before door moves"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for name in ("own_box.toml", "own_box.xml"):
        shutil.copy(EXAMPLES / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_model_obeys_its_rules_or_differs_in_one_line_that_the_page_shows(folder):
    said = ask("check", "own_box.toml", "own_box.xml").stdout
    assert said == f"{HEAD}\nown_box.xml: every push went as the rules say\n"
    rules = folder / "own_box.toml"
    rules.write_text(rules.read_text("utf-8").replace("pin = [{ bar = 0 }]", "pin = [{}]"), "utf-8")
    page = (EXAMPLES.parent / "docs" / "boxes.md").read_text("utf-8")
    with pytest.raises(BadFile, match="in configuration 011 .* pin was pushed: the rules let it move, and ") as found:
        ask("check", "own_box.toml", "own_box.xml")
    assert f"\nlockprobe: {found.value}\n" in page
