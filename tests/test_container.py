"""The image: it installs what exists, starts with the README's first command, and has the libraries that the docs name."""

import json
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
STEPS = [
    re.sub(r"\s+", " ", one).strip()
    for one in re.sub(r"\\\n", " ", re.sub(r"^#.*\n", "", (ROOT / "Dockerfile").read_text("utf-8"), flags=re.MULTILINE))
    .strip()
    .splitlines()
    if one.strip()
]
PAGE = (ROOT / "docs" / "install.md").read_text("utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))


def rest(instruction):
    """What follows an instruction, wherever it stands."""
    return [step.partition(" ")[2] for step in STEPS if step.split()[0] == instruction]


def installed():
    """Debian's packages in the image."""
    (command,) = [step for step in rest("RUN") if "libegl1" in step]
    return {*re.search(r"--no-install-recommends (.*?) &&", command)[1].split()}


def test_it_starts_with_the_first_command_of_the_readme_and_not_as_root():
    (entry,), (command,) = map(json.loads, rest("ENTRYPOINT")), map(json.loads, rest("CMD"))
    first = (ROOT / "README.md").read_text("utf-8").partition("## What you get")[0]
    assert f"uv run {' '.join([*entry, *command])}\n" in first
    last = STEPS[max(i for i, step in enumerate(STEPS) if step.startswith("FROM")) :]
    (user,) = [step.split()[1] for step in last if step.startswith("USER")]
    assert int(user) > 0
    assert last.index(f"USER {user}") < last.index(f"ENTRYPOINT {json.dumps(entry)}")


def test_the_libraries_of_the_docs_and_of_ci_are_in_it():
    table = (ROOT / "docs" / "install.md").read_text("utf-8").partition("## System libraries")[2]
    named = {name for cell in re.findall(r"\| `(lib[^`.]*)` \|", table) for name in cell.split()}
    assert {"libgomp1", "libegl1", "libopengl0", "libegl-mesa0", "libgl1-mesa-dri"} == named
    wanted = re.findall(r"^needs '\S+' +(?:'(.*?)'|(\S+))", (ROOT / ".ci" / "run").read_text("utf-8"), re.MULTILINE)
    assert named | {name for pair in wanted for name in "".join(pair).split()} == installed()


def test_what_is_copied_is_there_and_is_sent_to_the_builder():
    sent = {line[1:] for line in (ROOT / ".dockerignore").read_text("utf-8").splitlines() if line.startswith("!")}
    copied = {name for step in rest("COPY") for name in step.split()[:-1]}
    assert copied == sent
    assert all((ROOT / name).exists() for name in copied)
    metadata = {PROJECT["project"]["readme"], *PROJECT["project"]["license-files"]}
    assert metadata <= copied


def test_the_packages_are_those_of_the_lock_file():
    synced = [step for step in rest("RUN") if "uv sync" in step]
    assert len(synced) == 2
    assert all("--locked" in step and "--all-extras" in step for step in synced)
    assert {group for step in synced for group in re.findall(r"--group (\S+)", step)} <= {*PROJECT["dependency-groups"]}
    (base,) = rest("FROM")
    version = re.fullmatch(r"python:(3\.\d+)-slim-\w+", base)[1]
    assert f"Programming Language :: Python :: {version}" in PROJECT["project"]["classifiers"]
