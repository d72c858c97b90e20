"""The options of all commands: how many there are, and that one spelling has one explanation."""

import re
from collections import defaultdict

import pytest
import typer

from lockprobe.cli import build, every_command
from lockprobe.cli.headings import AS_RUN, Headed

MOST = 200
"""So many options a person can look through."""


def declared(command, path=""):
    """The options of a command and of its parts: path, option, whether help refers to ``lockprobe run`` for it."""
    groups = command.by_heading(typer.Context(command)) if isinstance(command, Headed) else {"Options": command.params}
    for heading, options in groups.items():
        for option in options:
            if option.param_type_name == "option" and option.name != "help":
                yield path, option, heading == AS_RUN
    for name, part in getattr(command, "commands", {}).items():
        yield from declared(part, f"{path} {name}".strip())


@pytest.fixture(scope="module")
def everything():
    return typer.main.get_command(build(every_command()))


def test_there_are_at_most_200_options(everything):
    """An option counts in every command whose help explains it; where help refers to ``run``, it counts there."""
    assert sum(not as_run for _, _, as_run in declared(everything)) <= MOST


def test_an_option_is_explained_in_one_way_by_all_commands(everything):
    """Brackets at the end say what holds in a command, such as its default."""
    said = defaultdict(lambda: defaultdict(list))
    for path, option, _ in declared(everything):
        for spelling in (*option.opts, *option.secondary_opts):
            said[spelling][re.sub(r"( \([^()]*\))?\.$", "", option.help)].append(path)
    assert {spelling: dict(texts) for spelling, texts in said.items() if len(texts) > 1} == {}


def test_an_explanation_belongs_to_one_spelling(everything):
    spelled = defaultdict(set)
    for _, option, _ in declared(everything):
        spelled[option.help].add("/".join(option.opts))
    assert {text: names for text, names in spelled.items() if len(names) > 1} == {}
