"""What a directory or a file says is data: no command that takes one runs code that it names.

Every command of the command line has a row here, so that a new one has to say which of its arguments come from elsewhere.
"""

import io
import sys
from collections.abc import Iterator
from itertools import product

import foreign
import pytest
import strangers
import typer
from builders import small_study, write_study
from placeholders import undrawn
from stored import sql

from lockprobe.cli import build, every_command, main
from lockprobe.foundation import plugins
from lockprobe.people.web import serving

NOTHING_FOREIGN = {
    "chance", "power", "play", "list agents", "list plants", "list interventions", "list models", "doctor",
    "box list", "box generate", "rig calibrate", "rig rehearse", "rig dry-run", "rig check",
}  # fmt: skip
"""Commands that take no directory of a study, no study file and no records."""

KEY = "flips/random/flip?p=0.4/rep=1/trial=1"

TAKING: dict[str, list[list[str]]] = {
    "run": [
        ["run", "flips", "--p", "0,0.4", "--trials", "2", "--out", "DIR"],
        ["run", "flips", "--p", "0,0.4", "--trials", "2", "--out", "DIR", "--estimate"],
        ["run", "flips", "--p", "0,0.4", "--trials", "2", "--out", "DIR", "--agent", "round-robin"],
        ["run", "flips", "--condition", "drop?p=0.5", "--trials", "2", "--out", "DIR", "--again", "reply"],
        ["run", "FILE"],
        ["run", "FILE", "--estimate"],
    ],
    "status": [["status", "DIR"], ["status", "DIR", "--json"]],
    "report": [["report", "DIR"], ["report", "DIR", "OTHER"]],
    "verify": [["verify", "DIR"], ["verify", "DIR", "--json"]],
    "export": [
        ["export", "DIR"],
        ["export", "DIR", "--format", "jsonl", "--out", "steps.jsonl"],
        ["export", "DIR", "--table", "calls"],
        ["export", "DIR", "--table", "records", "--format", "jsonl"],
    ],
    "import": [
        ["import", "mine", "DIR"],
        ["run", "flips", "--p", "0,0.4", "--trials", "2", "--out", "mine"],
        ["verify", "mine"],
        ["branch", "--at", "2", "mine"],
    ],
    "replay": [["replay", "DIR", KEY], ["replay", "DIR", KEY, "--out", "trial.gif"]],
    "branch": [
        ["branch", "DIR", "--at", "2"],
        ["branch", "DIR", "--at", "2", "--act", "random", "--then", "truth"],
        ["branch", "DIR", "--at", "2", "--estimate"],
        ["branch", "DIR", KEY, "--at", "2", "--allow", "python:canary:Other"],
    ],
    "serve": [["serve", "DIR", "--port", "0"], ["serve", "FILE", "--port", "0"]],
    "withdraw": [["withdraw", "DIR", "aaaa01"]],
    "mcp": [["mcp", "flips", "--p", "0,0.4", "--trials", "2", "--out", "DIR"], ["mcp", "FILE"]],
    "loops": [["loops", "DIR/study.db"]],
    "list measures": [["list", "measures", "DIR"], ["list", "measures", "DIR", "--json"]],
    "box show": [["box", "show", "FILE"]],
    "box solve": [["box", "solve", "FILE"]],
    "box check": [["box", "check", "FILE"]],
    "box view": [["box", "view", "FILE"]],
}
"""Command -> command lines, with DIR and OTHER for directories and FILE for a study file."""


def leaves(command: object, above: tuple[str, ...] = ()) -> Iterator[str]:
    for name, one in getattr(command, "commands", {"": None}).items():
        yield from leaves(one, (*above, name)) if one is not None else [" ".join(above)]


def test_every_command_has_its_row():
    every = set(leaves(typer.main.get_command(build(every_command()))))
    assert every == NOTHING_FOREIGN | TAKING.keys(), "say what a new command takes from elsewhere"
    assert not NOTHING_FOREIGN & TAKING.keys()


@pytest.fixture(scope="module", autouse=True)
def placeholders():
    """Figures take seconds, and none is looked at here."""
    with undrawn():
        yield


@pytest.fixture
def lockprobe(tmp_path, monkeypatch, capfd):
    """Runs a command in a directory with the canary; people's server stops as soon as people could come.

    What commands of another test named may not run in this one.
    """
    foreign.hatch(tmp_path)
    monkeypatch.setattr(plugins, "_named", set())
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO()))

    async def serve(directory, study, experiment, words, options, *, announce):
        async with serving.opened(directory, study, experiment, words, options) as (where, state):
            announce(where, state)

    monkeypatch.setattr(serving, "serve", serve)

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["lockprobe", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capfd.readouterr()
        return ended.value.code or 0, out, err

    yield run
    sys.modules.pop(foreign.MODULE, None)


@pytest.mark.parametrize(
    ("command", "kind"),
    [
        pytest.param(command, kind, marks=pytest.mark.slow if (command, kind) == ("replay", "plant") else ())
        for command, kind in product(TAKING, foreign.KINDS)
    ],
)
def test_no_command_runs_what_a_directory_or_a_file_names(tmp_path, lockprobe, command, kind):
    for number, line in enumerate(TAKING[command]):
        if line[-1] == "mine" and not (tmp_path / "mine").exists():  # it could not be imported
            continue
        files = foreign.study_files(tmp_path) if "FILE" in line else [tmp_path]
        for file in files if kind == "agents" or len(files) == 1 else []:
            names = {"FILE": str(file)}
            for name in ("DIR", "OTHER"):
                names[name] = (
                    str(foreign.directory(tmp_path / f"{name}-{number}", kind)) if any(name in a for a in line) else ""
                )
            given = [names.get(one, one.replace("DIR", names["DIR"])) for one in line]
            status, out, err = lockprobe(*given)
            assert not (tmp_path / foreign.SUNG).exists(), f"{' '.join(given)} ran it: {out}{err}"
            assert "Traceback" not in err, err
            assert foreign.MODULE not in sys.modules
            assert str(tmp_path) not in sys.path
            if status == 2:
                assert err.splitlines()[-1].startswith("lockprobe: "), err


SCHEMES = {
    "trigger": ["create trigger other after insert on trial begin insert into tally values ('ran', 1); end"],
    "view": ["alter table trial rename to other", "create view trial as select * from other"],
}
"""What SQLite would run in a store from elsewhere."""


@pytest.mark.parametrize("scheme", SCHEMES)
def test_no_command_reads_or_writes_a_store_that_has_more_than_tables(tmp_path, lockprobe, scheme):
    there = write_study(tmp_path / "there", small_study(["random"], (0.0, 0.4), trials=2))
    for statement in SCHEMES[scheme]:
        sql(there, statement)
    before = {path: path.read_bytes() for path in there.iterdir()}
    for line in (line for lines in TAKING.values() for line in lines if "DIR" in line):
        if line[0] == "mcp":  # it takes no directory within this one
            continue
        status, out, err = lockprobe(*(str(there) if one == "DIR" else one for one in line))
        assert status == (1 if line[0] == "verify" else 2), line
        assert f"{there}/study.db: its tables are not those of this release's studies" in out + err, line
        assert "Traceback" not in err
    assert {path: path.read_bytes() for path in there.iterdir()} == before


def test_the_same_name_runs_when_it_is_named_in_the_command(tmp_path, lockprobe):
    """So that the canary is one: it sings where a person names it, and forks need the name."""
    there = foreign.directory(tmp_path / "there", "agents")
    spec = foreign.AGENTS[1]
    status, _, err = lockprobe("branch", str(there), f"flips/{spec}/flip?p=0.4", "--at", "2")
    assert status == 2
    said = f"lockprobe: agent: got '{spec}', expected --allow with it in this command (in Python: "
    assert err.startswith(said)
    status, _, err = lockprobe("branch", str(there), f"flips/{spec}/flip?p=0.4", "--at", "2", "--allow", spec)
    assert status == 1, err  # it plays, and not as the strategy did whose records these are
    assert (tmp_path / foreign.SUNG).exists()


@pytest.mark.parametrize(
    ("kind", "named"), [("agents", foreign.AGENTS[1]), ("plant", foreign.PLANT), ("condition", foreign.ACTING)]
)
def test_one_s_own_study_is_resumed_by_the_command_that_began_it(tmp_path, lockprobe, kind, named):
    option = {"agents": "--agent", "plant": "--plant", "condition": "--condition"}[kind]
    rest = () if kind == "agents" else ("--agent", "random")
    begun = (
        "run",
        "flips",
        option,
        named,
        *rest,
        "--trials",
        "1",
        "--repetitions",
        "1",
        "--no-report",
        "--out",
        "mine",
    )
    for _ in range(2):
        status, _, err = lockprobe(*begun)
        assert status == 0, err
    for line in (
        ["status", "mine"],
        ["report", "mine"],
        ["verify", "mine"],
        ["list", "measures", "mine"],
        ["export", "mine"],
    ):
        assert lockprobe(*line)[0] == 0, line


def test_what_is_no_class_of_agents_is_refused_on_the_command_line_too(tmp_path, lockprobe):
    for spec in (foreign.CALL, f"python:subprocess:Popen?args=touch%20{foreign.SUNG}"):
        status, _, err = lockprobe("run", "flips", "--agent", spec, "--p", "0", "--out", "mine")
        assert (status, err.count("\n")) == (2, 1)
        assert "a module of your own" in err
    assert not (tmp_path / foreign.SUNG).exists()


def test_verify_runs_nothing_of_an_installed_package(tmp_path, monkeypatch, lockprobe):
    (tmp_path / "installed").mkdir()
    text = (tmp_path / f"{foreign.MODULE}.py").read_text("utf-8")
    strangers.install(tmp_path / "installed", monkeypatch, text=text)
    line = ["run", "flips", "--agent", "first", "--condition", "hush", "--trials", "2", "--repetitions", "1"]
    for plant in ("plain", "symbolic"):
        out = str(tmp_path / plant)
        assert lockprobe(*line, "--plant", plant, "--out", out)[0] == 0
        assert '"measures.untold"' in (tmp_path / plant / "results.json").read_text("utf-8")
        (tmp_path / foreign.SUNG).unlink()
        monkeypatch.delitem(sys.modules, "strange")
        status, said, _ = lockprobe("verify", out)
        assert status == 0, said
        left = {"plain": 4, "symbolic": 2}[plant]
        assert (
            f"; {left} more need a plant or an intervention that does not ship, or a real box, and are not played"
            in said
        )
        assert not (tmp_path / foreign.SUNG).exists()
