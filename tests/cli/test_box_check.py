"""``lockprobe box check``: a box file alone, and a MuJoCo model against its rules."""

import json
import re
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from mjcf_models import EXAMPLES, own_box
from typed import in_process

from lockprobe.boxes.boxfile import read_box
from lockprobe.boxes.observed_moves import Push
from lockprobe.cli import box_check
from lockprobe.cli.box_check import ModelCheck
from lockprobe.foundation import plugins
from lockprobe.foundation.errors import BadFile, BadValue, Missing
from lockprobe.trial.pictures.png import from_png

ask = partial(in_process, "box", "check")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for name in ("own_box.toml", "own_box.xml"):
        shutil.copy(EXAMPLES / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def rewrite(path, old, new):
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new), "utf-8")


def test_a_file_alone(folder):
    done = ask("own_box.toml")
    assert (done.exit_code, done.stdout.splitlines()) == (
        0,
        [
            "own_box.toml: can be played. 3 joints, target door, optimum 3 steps, 3 configurations before door moves",
            "human-inspired, told the truth, solves 100 % of trials in 20 steps",
        ],
    )
    found = json.loads(ask("own_box.toml", "--json").stdout)
    assert (found["reachable"], found["human_inspired_success"]) == (3, 1.0)
    assert ask("reset").stdout.splitlines()[1] == (
        "human-inspired, told the truth, solves 70 % of trials in 20 steps; 80 % need 24 (--max-steps 24)"
    )
    assert ask("gray-code").stdout.splitlines()[1] == "human-inspired, told the truth, solves 0 % of trials in 20 steps"
    rewrite(folder / "own_box.toml", "pin = 1", "pin = 2")
    with pytest.raises(BadFile, match=r"own_box.toml: interlock.bar.0.pin"):
        ask("own_box.toml")


def test_a_model_that_obeys_its_rules(folder):
    done = ask("own_box.toml", "own_box.xml")
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    assert lines[2] == "own_box.xml: 9 pushes in 3 configurations, all as the rules say"
    assert [line.split() for line in lines[4:8]] == [
        ["joint", "moved", "held", "differs"], ["door", "1", "2", "0"], ["bar", "2", "1", "0"], ["pin", "2", "1", "0"],
    ]  # fmt: skip
    assert lines[-3] == "the arm was not tried: lockprobe box check own_box.toml 'twin?model=own_box.xml&arm=yes'"
    assert lines[-2].startswith("picture: own_box-check.png (camera 'lockprobe', ")
    assert lines[-1] == "the camera sees every joint"
    picture = from_png((folder / "own_box-check.png").read_bytes())
    assert picture.shape == (480, 640, 3)
    assert (picture == 255).all(2).sum() > 300  # the names of the joints


def test_places_that_the_model_contradicts_are_said_in_one_line(folder):
    """A study whose reports tell places would tell these."""
    done = ask("own_box.toml", "own_box.xml", "--json")
    assert json.loads(done.stdout)["misplaced"] == []
    rewrite(folder / "own_box.toml", "place = [0.2, 0.5]", "place = [0.95, 0.2]")
    done = ask("own_box.toml", "own_box.xml")
    assert done.exit_code == 0
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("places differ")]
    assert (
        line == "places differ from left to right: own_box.toml says bar, pin, door; the picture shows door, bar, pin"
    )


def test_the_pictures_of_both_checks_lie_beside_the_model(folder, monkeypatch):
    (folder / "there").mkdir()
    shutil.move(folder / "own_box.xml", folder / "there")
    ask("own_box.toml", "there/own_box.xml")
    faked(monkeypatch, [], model=folder / "there" / "own_box.xml", dragged=())
    ask("own_box.toml", "own_box.xml")
    assert {one.name for one in folder.rglob("*.png")} == {"own_box-check.png", "own_box-arm-check.png"}
    assert {one.parent.name for one in folder.rglob("*.png")} == {"there"}


def test_an_arm_that_cannot_hold_the_handles(folder):
    rewrite(folder / "own_box.xml", 'size="0.015 0.02"', 'size="0.015 0.02" contype="0" conaffinity="0"')
    done = ask("own_box.toml", "twin?model=own_box.xml&arm=yes&width=160&height=120")
    said = done.stdout.splitlines()
    assert done.exit_code == 1
    assert said[2].endswith("all as the rules say")
    assert "the arm: 3 drags in 1 configuration, 3 not as the rules say" in said
    assert sum(" was dragged: the model held it, and the arm judged 'moved' at " in line for line in said) == 3
    assert (
        "what the arm needs: its hand holds a cylinder 3 cm across and 4 cm high, of contype 1, with 5 cm of room"
        in said
    )
    assert not any(line.startswith(("change line", "add to")) for line in said)


def test_what_the_arm_did(folder, monkeypatch):
    start = read_box(folder / "own_box.toml").initial
    held = Push(configuration=start, joint=0, allowed=False, moved=False)
    faked(monkeypatch, [held], dragged=(held, held))
    done = ask("own_box.toml", "own_box.xml")
    assert done.exit_code == 0
    assert "\nthe arm: 2 drags in 1 configuration, all as the rules say\n" in done.stdout
    assert "not tried" not in done.stdout
    faked(monkeypatch, [held], dragged=(replace(held, disagreement="it slipped"),))
    done = ask("own_box.toml", "own_box.xml", "--json")
    found = json.loads(done.stdout)
    assert (done.exit_code, found["holds"], found["differ"], found["arm"]["pushes"]) == (1, False, [], 1)
    assert (found["arm"]["differ"][0]["joint"], found["arm"]["differ"][0]["said"]) == ("door", "it slipped")


def test_the_line_that_is_printed_makes_rules_and_model_agree(folder):
    rewrite(folder / "own_box.toml", "pin = [{ bar = 0 }]", "pin = [{}]")
    rewrite(folder / "own_box.toml", "door = [{ bar = 1 }]", "door = [{ pin = 1 }]")
    done = ask("own_box.toml", "own_box.xml", "--out", "seen.png")
    assert done.exit_code == 1
    said = done.stdout.splitlines()
    assert "not compared: 1 configuration of the rules, which the model did not reach" in said
    assert sum(line.startswith("differs in ") for line in said) == 2
    changes = [line.split(": ", 1) for line in said if line.startswith("change line")]
    assert len(changes) == 2
    text = (folder / "own_box.toml").read_text("utf-8").splitlines()
    for place, line in changes:
        number = int(place.split()[2])
        assert text[number - 1].split(" =")[0] == line.split(" =")[0]
        text[number - 1] = line
    (folder / "own_box.toml").write_text("\n".join(text), "utf-8")
    assert ask("own_box.toml", "own_box.xml").exit_code == 0
    assert (folder / "seen.png").exists()


def test_a_missing_line_is_added(folder):
    rewrite(folder / "own_box.toml", "pin = [{ bar = 0 }]", "#")
    said = ask("own_box.toml", "own_box.xml").stdout
    assert "\nadd to own_box.toml, below [interlock]: pin = [{ bar = 0 }]\n" in said


def test_the_page_shows_what_is_printed(folder):
    rewrite(folder / "own_box.toml", "pin = [{ bar = 0 }]", "pin = [{}]")
    page = (EXAMPLES.parent / "docs" / "boxes.md").read_text("utf-8")
    shown = page.partition("lockprobe box check own_box.toml own_box.xml\n```\n\n```\n")[2].partition("```")[0]
    said = ask("own_box.toml", "own_box.xml").stdout
    assert re.sub(r", \w+\)$", ")", said, flags=re.MULTILINE) == re.sub(r", \w+\)$", ")", shown, flags=re.MULTILINE)


def test_as_json(folder):
    rewrite(folder / "own_box.toml", "pin = [{ bar = 0 }]", "pin = [{}]")
    done = ask("own_box.toml", "twin?model=own_box.xml&force=25", "--json")
    found = json.loads(done.stdout)
    assert (done.exit_code, found["holds"], found["pushes"], found["configurations"]) == (1, False, 9, 3)
    assert found["lines"] == {"pin": "pin = [{ bar = 0 }]"}
    assert (found["not_reached"], found["out_of_view"], found["picture"]) == (["010"], {}, "own_box-check.png")
    (wrong,) = found["differ"]
    assert (wrong["configuration"], wrong["joint"], wrong["allowed"], wrong["moved"]) == ("011", "pin", True, False)
    assert found["arm"] is None


def faked(monkeypatch, pushes, **found):
    none = {"dragged": None, "with_arm": "twin?arm=yes", "handle": "", "out_of_view": {}, "picture": b"", "view": ""}
    none["handles"] = tuple((joint.place[0], 1 - joint.place[1]) for joint in own_box().joints)
    none["model"] = Path("own_box.xml")
    check = ModelCheck(pushes=tuple(pushes), renderer="none", **{**none, **found})
    monkeypatch.setattr(box_check, "robot_tool", lambda name, what: lambda box, model: check)


def test_what_no_line_can_mend_is_said(folder, monkeypatch):
    box = read_box(folder / "own_box.toml")
    held = [Push(configuration=box.initial, joint=2, allowed=True, moved=False, disagreement="the model held pin")]
    torn = [Push(configuration=box.initial, joint=1, allowed=False, moved=None, disagreement="between its ends")]
    faked(monkeypatch, held + torn)
    done = ask("own_box.toml", "own_box.xml")
    assert done.exit_code == 1
    assert "\npin never moved, and no rule can say that: change the model\n" in done.stdout
    assert "\nno rule can describe 1 push: change the model\n" in done.stdout
    assert "change line" not in done.stdout
    many = [Push(configuration=box.initial, joint=1, allowed=False, moved=None, disagreement="x")] * 12
    faked(monkeypatch, many)
    assert "\nand 2 more (--json)\n" in ask("own_box.toml", "own_box.xml").stdout


def test_lines_that_would_make_an_unplayable_box_are_said_to(folder, monkeypatch):
    box = read_box(folder / "own_box.toml")
    moves = [
        Push(configuration=now, joint=0, allowed=box.may_move(now, 0), moved=now == (False, True, False), disagreement="d")
        for now in ((False, bar, pin) for bar in (False, True) for pin in (False, True))
    ]  # fmt: skip
    faked(monkeypatch, moves)
    said = ask("own_box.toml", "own_box.xml").stdout
    assert "with these lines the box could not be played (unsolvable: no sequence of attempts moves door)" in said


@pytest.mark.parametrize(
    ("words", "mistake", "message"),
    [
        (["own_box.xml"], BadValue, "expected a name or FILE.toml with its rules; a MuJoCo model is a plant: --plant"),
        (["own_box.toml", "none.xml"], BadFile, "none.xml: cannot be read"),
        (["own_box.toml", "own_box.toml"], BadFile, "own_box.toml: not XML"),
        (["chain-4", "own_box.xml"], BadFile, "expected one called 'revolute-left', as in the box"),
        (["own_box.toml", "own_box.xml", "--out", "x.jpg"], BadValue, "a file name that ends in .png"),
        (["own_box.toml", "twin?looks=varied"], BadValue, "an MJCF file, or 'twin.model=FILE' with options"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_mistakes_are_one_line(words, mistake, message):
    with pytest.raises(mistake, match=message) as found:
        ask(*words)
    assert "\n" not in str(found.value)


def test_without_lockprobe_robot_the_model_needs_it_and_the_file_does_not(folder, monkeypatch):
    monkeypatch.setattr(plugins, "find_plugin", lambda kind, name: None)
    assert ask("own_box.toml").exit_code == 0
    with pytest.raises(Missing, match=r"^checks of a MuJoCo model need the package lockprobe-robot: .*twin"):
        ask("own_box.toml", "own_box.xml")
