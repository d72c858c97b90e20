"""No command writes through a link inside a study directory, whatever of it is one."""

import io
import re
import shutil
import sys
from pathlib import Path

import pytest
from builders import small_study, write_study
from placeholders import undrawn
from taking_part import take_part

from lockprobe.cli import main
from lockprobe.people.web import app
from lockprobe.trial.record import STATES

SETTINGS = ["flips", "--p", "0,0.3,0.6", "--repetitions", "2", "--trials", "4"]
STORE = ("study.json", "study.db", "study.db-wal", "study.db-shm", "study.db-journal")

WRITE = {
    "run": (["run", *SETTINGS, "--agent", "round-robin"], STORE),
    "report": (["report"], ("report.html", "figures/fig4.svg", "figures")),
    "branch": (["branch", "--at", "3"], ("forks", "forks/study.db", "forks/study.json")),
    "import": (["import"], ("study.json", "study.db", "people")),
    "serve": (["serve"], ("study.db", "people", "people/experiment.json")),
    "mcp": (["mcp", *SETTINGS], ("study.db",)),
    "export": (["export", "--out", "DIR/steps.csv"], ("steps.csv",)),
}
"""Command -> its arguments, and what it writes in a study directory; all that write a store do it as ``run`` does."""


def lockprobe(monkeypatch, directory, line, other):
    """Runs a command; its exit status."""
    given = [one.replace("DIR", str(directory)) for one in line]
    where = {"run": ["--no-report", "--out"], "mcp": ["--out"]}.get(line[0], [])
    given += [*where, str(directory), *{"import": [str(other)], "serve": ["--port", "0"]}.get(line[0], [])]
    monkeypatch.setattr(sys, "argv", ["lockprobe", *given])
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO()))
    with pytest.raises(SystemExit) as ended:
        main()
    return ended.value.code or 0


@pytest.fixture(scope="module", autouse=True)
def placeholders():
    """Figures take seconds, and none is looked at here."""
    with undrawn():
        yield


@pytest.fixture
def no_server(monkeypatch):
    async def serve(directory, study, experiment, words, options, *, announce):
        async with app.opened(directory, study, experiment, words, options) as (where, state):
            announce(where, state)

    monkeypatch.setattr(app, "serve", serve)


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """A study of which some trials are owed, with all that commands write there."""
    made = tmp_path_factory.mktemp("links")
    write_study(made / "study", small_study(["random"], trials=4))
    write_study(made / "other", small_study(["human-inspired"], trials=4))
    people = small_study(["human-inspired", "participant"], trials=4)
    take_part(made / "other", people, "aaaa0001", [(0.0, 1, 1), (0.3, 1, 2)], shown=STATES)
    monkeypatch = pytest.MonkeyPatch()
    assert lockprobe(monkeypatch, made / "study", WRITE["branch"][0], made / "other") == 0
    monkeypatch.undo()
    for name in {name for _, names in WRITE.values() for name in names}:
        path = made / "study" / name
        if not path.exists():
            path.parent.mkdir(exist_ok=True)
            path.mkdir() if not path.suffix else path.write_bytes(b"{}" if path.suffix == ".json" else b"")
    return made


def snapshot(path):
    if path.is_file():
        return path.read_bytes()
    return {str(one): one.read_bytes() if one.is_file() else "" for one in sorted(path.rglob("*"))}


def each(tmp_path, played, names):
    """The study with each of these names in turn, and what it stood for, moved away."""
    for number, name in enumerate(names):
        directory, victim = tmp_path / str(number) / "study", tmp_path / f"victim-{number}"
        shutil.copytree(played, tmp_path / str(number))
        shutil.move(directory / name, victim)
        yield directory, directory / name, victim


@pytest.mark.usefixtures("no_server")
@pytest.mark.parametrize("command", WRITE)
def test_no_command_writes_through_a_link(tmp_path, monkeypatch, capsys, played, command):
    line, names = WRITE[command]
    for directory, link, victim in each(tmp_path, played, names):
        link.symlink_to(victim)
        before = snapshot(victim)
        status = lockprobe(monkeypatch, directory, line, directory.parent / "other")
        said = capsys.readouterr().err
        assert snapshot(victim) == before, f"it wrote through {link}: {said}"
        assert link.is_symlink()
        assert status == 2, (link, said)
        last = said.splitlines()[-1]
        assert last.startswith(f"lockprobe: {link}: "), said
        assert "link" in last.removeprefix(f"lockprobe: {link}: ")


@pytest.mark.usefixtures("no_server")
def test_a_study_begun_in_a_directory_of_links_is_refused(tmp_path, monkeypatch, capsys):
    (tmp_path / "victim").write_text("mine\n")
    for name in ("study.db", "study.db-wal", "study.json", "people"):
        directory = tmp_path / name
        directory.mkdir()
        for leads in ("../missing",) if name == "study.json" else ("../victim", "../missing"):
            (directory / name).unlink(missing_ok=True)
            (directory / name).symlink_to(leads)
            assert lockprobe(monkeypatch, directory, ["run", "flips", "--agent", "random"], tmp_path) == 2
            said = capsys.readouterr().err
            assert re.fullmatch(f"lockprobe: {directory / name}: is a link.*, which is not followed: remove it\n", said)
    assert (tmp_path / "victim").read_text() == "mine\n"
    assert not (tmp_path / "missing").exists()


def test_a_study_whose_directory_is_a_link_is_played(tmp_path, monkeypatch, played):
    shutil.copytree(played, tmp_path / "all")
    (tmp_path / "link").symlink_to(Path("all") / "study")
    for name in ("run", "branch"):
        assert lockprobe(monkeypatch, tmp_path / "link", WRITE[name][0], tmp_path) == 0
