"""No command writes through a link inside a study directory, whatever of it is one."""

import re
import shutil
from pathlib import Path

import pytest
from builders import small_study, write_study
from taking_part import take_part
from typed import typed_here

from lockprobe.trial.record import STATES

pytestmark = pytest.mark.usefixtures("placeholders")

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


def lockprobe(directory, line, other=None):
    """Runs a command; its exit status and what it says."""
    given = [one.replace("DIR", str(directory)) for one in line]
    where = {"run": ["--no-report", "--out"], "mcp": ["--out"]}.get(line[0], [])
    given += [*where, str(directory), *{"import": [str(other)], "serve": ["--port", "0"]}.get(line[0], [])]
    done = typed_here(*given)
    return done.returncode, done.stderr


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """A study of which some trials are owed, with all that commands write there."""
    made = tmp_path_factory.mktemp("links")
    write_study(made / "study", small_study(["random"], trials=4))
    write_study(made / "other", small_study(["human-inspired"], trials=4))
    people = small_study(["human-inspired", "participant"], trials=4)
    take_part(made / "other", people, "aaaa0001", [(0.0, 1, 1), (0.3, 1, 2)], shown=STATES)
    assert lockprobe(made / "study", WRITE["branch"][0])[0] == 0
    for name in {name for _, names in WRITE.values() for name in names}:
        path = made / "study" / name
        if not path.exists():
            path.parent.mkdir(exist_ok=True)
            path.mkdir() if not path.suffix else path.write_bytes(b"{}" if path.suffix == ".json" else b"")
    return made


def snapshot(path):
    return {str(one): one.is_file() and one.read_bytes() for one in (path, *path.rglob("*"))}


@pytest.mark.parametrize("command", WRITE)
def test_no_command_writes_through_a_link(tmp_path, played, command):
    line, names = WRITE[command]
    for number, name in enumerate(names):
        shutil.copytree(played, tmp_path / str(number))
        victim, link = tmp_path / f"victim-{number}", tmp_path / str(number) / "study" / name
        shutil.move(link, victim)
        link.symlink_to(victim)
        before = snapshot(victim)
        status, said = lockprobe(tmp_path / str(number) / "study", line, tmp_path / str(number) / "other")
        assert snapshot(victim) == before, f"it wrote through {link}: {said}"
        assert (link.is_symlink(), status) == (True, 2), (link, said)
        last = said.splitlines()[-1]
        assert last.startswith(f"lockprobe: {link}: "), said
        assert "link" in last.removeprefix(f"lockprobe: {link}: ")


def test_a_study_begun_in_a_directory_of_links_is_refused(tmp_path):
    (tmp_path / "victim").write_text("mine\n")
    for name in ("study.db", "study.db-wal", "study.json", "people"):
        directory = tmp_path / name
        directory.mkdir()
        for leads in ("../missing",) if name == "study.json" else ("../victim", "../missing"):
            (directory / name).unlink(missing_ok=True)
            (directory / name).symlink_to(leads)
            status, said = lockprobe(directory, ["run", "flips", "--agent", "random"])
            assert status == 2
            assert re.fullmatch(f"lockprobe: {directory / name}: is a link.*, which is not followed: remove it\n", said)
    assert (tmp_path / "victim").read_text() == "mine\n"
    assert not (tmp_path / "missing").exists()


def test_a_study_whose_directory_is_a_link_is_played(tmp_path, played):
    shutil.copytree(played, tmp_path / "all")
    (tmp_path / "link").symlink_to(Path("all") / "study")
    for name in ("run", "branch"):
        assert lockprobe(tmp_path / "link", WRITE[name][0])[0] == 0
