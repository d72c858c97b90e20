"""The image starts with the README's first command, from what is sent to the builder, with the libraries of the docs."""

import json
import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
IMAGE = re.sub(r"\\\n\s*", "", (ROOT / "Dockerfile").read_text("utf-8"))


def test_it_starts_with_the_first_command_of_the_readme_and_not_as_root():
    (entry,), (command,) = (
        map(json.loads, re.findall(rf"^{name} (.*)$", IMAGE, re.MULTILINE)) for name in ("ENTRYPOINT", "CMD")
    )
    first = (ROOT / "README.md").read_text("utf-8").partition("## What you get")[0]
    assert f"uv run {' '.join([*entry, *command])}\n" in first
    assert re.search(r"^USER [1-9]\d*\n(?:(?!USER|FROM).*\n)*ENTRYPOINT", IMAGE, re.MULTILINE)


def test_what_is_copied_is_there_and_the_libraries_of_the_docs_are_in_it():
    sent = {line[1:] for line in (ROOT / ".dockerignore").read_text("utf-8").splitlines() if line.startswith("!")}
    copied = {name for line in re.findall(r"^COPY (.*) \S+$", IMAGE, re.MULTILINE) for name in line.split()}
    assert copied == sent
    assert all((ROOT / name).exists() for name in copied)
    table = (ROOT / "docs" / "install.md").read_text("utf-8").partition("## System libraries")[2]
    named = {name for cell in re.findall(r"\| `(lib[^`.]*)` \|", table) for name in cell.split()}
    installed = {*re.search(r"--no-install-recommends (.*?libegl1.*?) &&", IMAGE)[1].split()}
    assert named
    assert named <= installed
