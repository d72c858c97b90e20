"""What other packages add is found by its name, imported late, and breaks in one line."""

import subprocess
import sys

import pytest
import strangers
from typed import typed_here

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.families import box, find_box
from lockprobe.foundation import plugins
from lockprobe.foundation.errors import BadValue, BrokenPlugin, UnknownName, UserMistake
from lockprobe.foundation.plugins import (
    GROUPS,
    allow,
    allowed,
    find_plugin,
    no_foreign_code,
    plugin_name_of,
    plugin_names,
)
from lockprobe.interventions.conditions import interventions_of
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.statistics.measures import find_measure
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.condition import spec_of
from lockprobe.trial.trial_json import trial_from_json, trial_to_json

USES = {
    "agent": lambda spec: resolve(spec).make(),
    "box": find_box,
    "intervention": interventions_of,
    "measure": find_measure,
    "plant": lambda spec: resolve_plant(spec).check(box()),
    "plant source": lambda spec: resolve_plant(spec).check(box()),
}
"""What is added -> how a spec of it is used."""


@pytest.fixture(autouse=True)
def fresh(monkeypatch):
    """Nothing has been named yet."""
    monkeypatch.setattr(plugins, "_named", set())


@pytest.fixture
def strange(tmp_path, monkeypatch):
    strangers.install(tmp_path, monkeypatch)


@pytest.mark.usefixtures("strange")
def test_a_package_adds_one_of_each_kind_by_name():
    assert {kind: plugin_names(kind) for kind in GROUPS} == {
        "agent": ("first",), "box": ("gate",), "intervention": ("hush",), "measure": ("untold",), "plant": ("plain",),
        "command": (), "plant source": ("seen",), "tool": (),
    }  # fmt: skip
    trial = run_trial(agent="first?place=2", box="gate?size=4", plant="plain?force=2", condition="hush?steps=2")
    assert (trial.agent, trial.box, trial.joints[0]) == ("first?place=2", "gate-4", "gate")
    assert trial.facts == {"place": 2}
    assert trial.plant == {"plant": "plain?force=2", "force": 2.0}
    assert [step.told_moved is None for step in trial.steps[:3]] == [True, True, False]
    assert find_measure("untold")(trial) == pytest.approx(2 / 20)
    assert find_measure("untold?weight=2.5")(trial) == pytest.approx(5 / 20)
    assert trial_from_json(trial_to_json(trial)) == trial


@pytest.mark.usefixtures("strange")
def test_the_same_stands_behind_python_without_an_entry_point_and_is_written_with_the_name_of_its_package():
    agent, gate, plant = "python:strange:First?place=1", "python:strange:GATE", "python:strange:Plain"
    trial = run_trial(agent=agent, box=gate, plant=plant, condition="python:strange:Hush?steps=3 + tremble?p=0")
    assert (trial.box, trial.plant["plant"], trial.agent) == ("gate-4", plant, agent)
    assert find_measure("python:strange:hasty")(trial) is False
    allow("python:strange:Hush?steps=2")
    (hush,) = interventions_of("python:strange:Hush?steps=2")
    assert spec_of(hush) == "hush?steps=2"
    assert plugin_name_of("intervention", type(resolve("first").make())) == "python:strange:First"


@pytest.mark.usefixtures("strange")
@pytest.mark.parametrize(
    ("kind", "spec", "said"),
    [
        ("agent", "first?plaice=1", "no option of first is called 'plaice' (did you mean 'place'?)"),
        ("agent", "first?place=one", "place: got 'one', expected a whole number"),
        ("agent", "frist", "no agent is called 'frist' (did you mean 'first'?)"),
        ("agent", "python:strange:Quits", "agent 'python:strange:Quits' does not work (SystemExit: it quits)"),
        ("box", "python:strange:hasty", "box 'python:strange:hasty' does not work (TypeError: "),
        ("box", "python:strange:breaks", "box 'python:strange:breaks' does not work (ZeroDivisionError: by nothing)"),
        ("box", "python:strange:First", "expected a Lockbox, or a function that returns one"),
        ("box", "python:strange:GATE?size=3", "expected no options: it is a Lockbox"),
        ("box", "gate?size=9", "joints: got 9, expected at most 8"),
        ("box", "python:strange:STUCK", "expected one that can be played (unsolvable: no sequence"),
        ("plant", "python:strange:First", "expected a class with `facts`, `observe()`"),
        ("plant", "python:strange:falls", "plant 'python:strange:falls' does not work (SystemExit: it falls)"),
        ("plant", "plan", "no plant is called 'plan' (did you mean 'plain'?)"),
        ("intervention", "hush?steps=few", "steps: got 'few', expected a whole number"),
        ("intervention", "python:strange:First", "expected a frozen dataclass"),
        ("measure", "untold?trial=1", "no option of untold is called 'trial'"),
        ("measure", "solved?x=1", "expected solved without options"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_line(kind, spec, said):
    allow(spec)
    with pytest.raises(UserMistake) as mistake:
        USES[kind](spec)
    assert said in str(mistake.value)
    assert "\n" not in str(mistake.value)


BROKEN = "import not_installed_anywhere\n"
NAMED = "of broken-things 0.3 does not work (ModuleNotFoundError: No module named 'not_installed_anywhere')"


@pytest.fixture
def broken(tmp_path, monkeypatch):
    """One package that works, and one that does not and adds as many of each kind."""
    for name in ("good", "bad"):
        (tmp_path / name).mkdir()
    strangers.install(tmp_path / "good", monkeypatch)
    bad = {group: {f"bad-{group}": "Thing"} for group in strangers.POINTS}
    strangers.install(tmp_path / "bad", monkeypatch, "broken", BROKEN, bad, "broken-things")


@pytest.mark.usefixtures("broken")
@pytest.mark.parametrize("kind", USES)
def test_a_broken_package_is_named_by_those_who_use_it_and_disturbs_nobody_else(kind):
    with pytest.raises(BrokenPlugin) as mistake:
        USES[kind](GROUPS[kind].replace("lockprobe.", "bad-"))
    assert str(mistake.value).endswith(NAMED)
    assert run_trial(agent="first", box="gate", plant="plain", condition="hush + drop?p=0.5").steps
    assert "broken" not in sys.modules


def test_a_name_of_lockprobe_s_own_cannot_be_taken(tmp_path, monkeypatch):
    taken = {
        "agents": {"random": "First"}, "interventions": {"drop": "Hush"}, "boxes": {"fork": "gate"},
        "commands": {"chance": "shout", "rig": "shout"}, "plant_sources": {"twin": "seen"}, "tools": {"film": "shout"},
    }  # fmt: skip
    strangers.install(tmp_path, monkeypatch, points=taken)
    assert type(resolve("random").make()).__name__ == "RandomAgent"
    assert type(interventions_of("drop")[0]).__name__ == "Drop"
    assert find_box("fork") == box("fork")
    assert "Lockprobe itself uses this one (strange-things 0.3)" in typed_here("list", "interventions").stdout
    assert find_plugin("plant source", "twin").ships
    assert find_plugin("command", "rig").ships
    assert find_plugin("tool", "film").ships
    assert typed_here("chance", "--length", "3", "--json").returncode == 0


def test_a_name_that_two_packages_add_is_refused_with_both(tmp_path, monkeypatch):
    for module in ("one", "two"):
        (tmp_path / module).mkdir()
        strangers.install(tmp_path / module, monkeypatch, module, points={"boxes": {"gate": "gate"}}, package=module)
    with pytest.raises(BadValue, match="box: got 'gate', expected a name from only one package, not from .* and "):
        find_box("gate")


def test_nothing_of_a_package_is_imported_before_it_is_used(tmp_path, monkeypatch):
    strangers.install(tmp_path, monkeypatch, text="raise SystemExit('it ran')")
    assert resolve("first?place=2").sees
    assert not resolve_plant("plain").has_camera
    assert not resolve_plant("python:strange:Plain").has_camera
    assert find_plugin("box", "gate").package == "strange-things 0.3"
    with pytest.raises(UnknownName, match="gate"):
        box("gate")  # what a record names is a box of Lockprobe's own, or none


@pytest.mark.usefixtures("strange")
@pytest.mark.parametrize(
    ("kind", "spec"),
    [
        ("agent", "python:strange:First?place=1"),
        ("intervention", "python:strange:Hush?steps=2"),
        ("plant", "python:strange:Plain"),
    ],
)
def test_what_no_person_has_named_is_not_imported(kind, spec):
    sys.modules.pop("strange", None)
    for named in ((), (f"{spec}1",) if kind == "agent" else ("python:strange:GATE",)):
        allow(*named)
        with pytest.raises(
            BadValue, match="expected --allow with it in this command .*: what a file or a directory names"
        ):
            USES[kind](spec)
    assert "strange" not in sys.modules
    allow(f"tremble?p=0.1 + {spec}" if kind == "intervention" else spec)
    USES[kind](spec)
    assert spec in allowed()


@pytest.mark.usefixtures("strange")
def test_nothing_of_others_runs_where_none_may():
    allow("python:strange:First")
    with no_foreign_code():
        for kind, spec in {"agent": "python:strange:First", "intervention": "hush", "plant": "plain"}.items():
            with pytest.raises(BadValue, match="no other code runs here"):
                USES[kind](spec)
    assert USES["agent"]("python:strange:First").facts == {"place": 0}


SAID = """
import subprocess
import sys
from lockprobe.cli import main
from lockprobe.foundation.plugins import docstring
from own import Twice, half

for line in ("list agents", "list plants", "list interventions", "run --help", "--help"):
    sys.argv = ["lockprobe", *line.split()]
    try: main()
    except SystemExit: pass
print([docstring(one) for one in (Twice, Twice(1), half, len, lambda: 1)][:3])
"""


def test_lists_and_help_say_the_same_where_python_drops_docstrings(tmp_path):
    own = 'from dataclasses import dataclass\n@dataclass\nclass Twice:\n    """Doubled."""\n    n: int\n'
    (tmp_path / "own.py").write_text(own + 'def half():\n    "Halved."\n', "utf-8")
    plain, without = (
        subprocess.run([sys.executable, *option, "-c", SAID], cwd=tmp_path, capture_output=True, text=True, check=True)
        for option in ([], ["-OO"])
    )
    assert plain.stdout.splitlines()[-1] == "['Doubled.', 'Doubled.', 'Halved.']"
    assert without.stdout == plain.stdout
