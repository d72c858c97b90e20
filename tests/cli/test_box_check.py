"""``lockprobe box check``: a box file alone, and a MuJoCo model against its rules."""

import shutil
from functools import partial

import pytest
from mjcf_models import EXAMPLES
from typed import in_process

from lockprobe.foundation import plugins
from lockprobe.foundation.errors import BadFile, BadValue, Missing

ask = partial(in_process, "box", "check")

HEAD = "own_box.toml: can be played. 3 joints, target door, optimum 3 steps, 3 configurations before door moves"


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
    assert (done.exit_code, done.stdout.splitlines()) == (0, [HEAD])
    rewrite(folder / "own_box.toml", "pin = 1", "pin = 2")
    with pytest.raises(BadFile, match=r"own_box.toml: interlock.bar.0.pin"):
        ask("own_box.toml")


@pytest.mark.usefixtures("folder")
def test_a_model_that_obeys_its_rules():
    done = ask("own_box.toml", "own_box.xml")
    assert done.exit_code == 0
    first, second = done.stdout.splitlines()
    assert first == HEAD
    assert second == "own_box.xml: every push went as the rules say"


def test_a_model_that_differs_is_one_line_that_the_page_shows(folder):
    rewrite(folder / "own_box.toml", "pin = [{ bar = 0 }]", "pin = [{}]")
    page = (EXAMPLES.parent / "docs" / "boxes.md").read_text("utf-8")
    with pytest.raises(BadFile, match="in configuration 011 .* pin was pushed: the rules let it move, and ") as found:
        ask("own_box.toml", "own_box.xml")
    assert f"\nlockprobe: {found.value}\n" in page


@pytest.mark.parametrize(
    ("words", "mistake", "message"),
    [
        (["own_box.xml"], BadValue, "expected a name or FILE.toml with its rules; a MuJoCo model is a plant: --plant"),
        (["own_box.toml", "none.xml"], BadFile, "none.xml: cannot be read"),
        (["own_box.toml", "own_box.toml"], BadFile, "own_box.toml: not XML"),
        (["chain-4", "own_box.xml"], BadFile, "expected one called 'revolute-left', as in the box"),
        (["own_box.toml", "twin?model="], BadValue, "expected an MJCF file"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_mistakes_are_one_line(words, mistake, message):
    with pytest.raises(mistake, match=message) as found:
        ask(*words)
    assert "\n" not in str(found.value)


@pytest.mark.usefixtures("folder")
def test_without_lockprobe_robot_the_model_needs_it_and_the_file_does_not(monkeypatch):
    monkeypatch.setattr(plugins, "find_plugin", lambda kind, name: None)
    assert ask("own_box.toml").exit_code == 0
    with pytest.raises(Missing, match="twin"):
        ask("own_box.toml", "own_box.xml")
