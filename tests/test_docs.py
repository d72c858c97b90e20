"""What README and docs show runs as it is typed: every block of Python, every command line, every table of settings."""

import re
import shlex
import sys
import tomllib
from functools import cache
from pathlib import Path

import pytest
import typer
from typer.exceptions import TyperException

from lockprobe.agents.catalogue import KNOWN, resolve
from lockprobe.boxes.boxfile import read_box
from lockprobe.cli import build
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.testing import check_agent

ROOT = Path(__file__).parents[1]
PAGES = sorted(
    {ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "robot").glob("**/*.md")}
)
PAGE = {page.relative_to(ROOT).as_posix(): page.read_text("utf-8") for page in PAGES}

NOT_RUN = ('plant="fast-twin', "num_envs=1000", "trials=5_000")
"""What a block holds that is compiled only, because it takes seconds."""


def blocks(text, kind):
    return re.findall(rf"^```{kind}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("page", [page for page, text in PAGE.items() if "```python" in text])
def test_python_runs_as_typed(page, tmp_path, monkeypatch):
    """The blocks of one page are one session: what an earlier one made, a later one may use."""
    pytest.importorskip("gymnasium")
    monkeypatch.chdir(tmp_path)
    session = {"__name__": "typed"}
    for text in blocks(PAGE[page], "python"):
        code = compile(text, page, "exec")
        if not any(what in text for what in NOT_RUN):
            exec(code, session)


def test_one_s_own_agents_are_found_in_the_working_directory_and_play(tmp_path, monkeypatch):
    section = PAGE["docs/agents.md"].partition("\n## Your own agent\n")[2].partition("\n## ")[0]
    (code,) = blocks(section, "python")
    (tmp_path / "mine.py").write_text(code, "utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", list(sys.path))
    named = re.findall(r"python:mine:[A-Z]\w+(?= )", section)
    assert named == [f"python:mine:{name}" for name in re.findall(r"^class (\w+)", code, re.MULTILINE)]
    for agent in named:
        check_agent(agent)
    del sys.modules["mine"]


def command_lines():
    """Whatever stands in a block or between backticks and begins with the command."""
    for page, whole in PAGE.items():
        lines = [line for block in blocks(whole, "(?:sh)?") for line in block.splitlines()]
        lines += re.findall(r"^    (.*)$", whole, re.MULTILINE)
        lines += re.findall(r"`([^`\n]*)`", re.sub(r"^```.*?^```$", "", whole, flags=re.DOTALL | re.MULTILINE))
        for line in lines:
            found = re.match(r"(?:pip install uv && )?(?:uv run (?:--\S+ )*)?lockprobe (\S.*)", line.strip())
            if found:
                yield page, re.split(r"\s{2,}|\s+#|\s\|\s", found[1])[0].strip()


LINES = sorted({line for _, line in command_lines()})
PLACEHOLDERS = ("…", "...")


def test_every_command_line_parses():
    """Its options exist, and their values can be read; nothing is run."""
    groups = cache(lambda command: typer.main.get_command(build([command])))
    for line in LINES:
        words = [word for word in shlex.split(line) if word not in PLACEHOLDERS]
        if words[0].startswith("-") or words[0] == "NAME" or "--help" in words:
            continue
        command, rest = groups(words[0]).commands[words[0]], words[1:]
        if hasattr(command, "commands") and rest:
            command, rest = command.commands[rest[0]], rest[1:]
        options = {name for option in command.params for name in (*option.opts, *option.secondary_opts)}
        assert {word.partition("=")[0] for word in rest if word.startswith("--")} <= options, line
        refused = ""
        try:
            command.make_context(words[0], [{"s": "1"}.get(word, word) for word in rest])
        except TyperException as mistake:  # some lines only name a command, or an option
            refused = mistake.format_message()
        assert re.match(r"$|Missing argument|Option '.*' requires an argument", refused), f"{line}: {refused}"


@pytest.mark.parametrize("text", [text for whole in PAGE.values() for text in blocks(whole, "toml")])
def test_toml_is_what_it_says(text, tmp_path):
    tomllib.loads(text)
    if "[interlock]" in text:
        (tmp_path / "x.toml").write_text(text, "utf-8")
        assert read_box(tmp_path / "x.toml").joints
    elif re.search(r"^study = ", text, re.MULTILINE):
        (tmp_path / "mine.toml").write_text(text, "utf-8")
        assert study(tmp_path / "mine.toml").agents


def test_links_lead_to_files_and_headings_that_exist():
    broken = []
    for page, text in PAGE.items():
        prose = re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
        for target in re.findall(r"\]\(([^)\s]+)\)", prose):
            name, _, anchor = target.partition("#")
            there = (ROOT / page).parent / name if name else ROOT / page
            if target.startswith(("http", "mailto:")):
                continue
            heads = re.findall(r"^#+ (.*)$", there.read_text("utf-8"), re.MULTILINE) if anchor else ()
            anchors = {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}
            if not there.exists() or (anchor and anchor not in anchors):
                broken.append((page, target))
    assert broken == []


def test_every_page_is_in_the_index():
    index = PAGE["docs/README.md"]
    pages = {page.name for page in (ROOT / "docs").glob("*.md")} - {"README.md"}
    pages |= {f"../robot/docs/{page.name}" for page in (ROOT / "robot" / "docs").glob("*.md")}
    assert {name for name in pages if f"]({name})" not in index} == set()
    assert "](docs/README.md)" in PAGE["README.md"]


@pytest.mark.parametrize(
    "spec",
    sorted({one for whole in PAGE.values() for one in re.findall(r"--agent '?([^\s'`]+)", whole)} - {"llm:gguf:PATH"}),
)
def test_an_agent_that_is_named_exists(spec):
    (alone,), _ = StudyOptions(agent=spec).agents
    assert resolve(alone).spec == alone


def test_the_agents_of_the_table_are_there():
    table = PAGE["docs/agents.md"].partition("| agent | what it is |")[2].partition("\n\n")[0]
    named = {
        name for first in re.findall(r"^\| (.*?) \|", table, re.MULTILINE) for name in re.findall(r"`(.*?)`", first)
    }
    assert named - set(KNOWN) == {"cognitive:MODEL"}
