"""The options of all commands: how many there are, that one spelling has one explanation, and that one value is one."""

import re
from collections import defaultdict

import pytest
import typer
from typer.exceptions import TyperException

from lockprobe.cli import build, every_command
from lockprobe.cli.command import AS_RUN, Command
from lockprobe.foundation.errors import UserMistake

MOST = 200
"""So many options a person can look through."""


def declared(command, path=""):
    """The options of a command and of its parts: path, option, whether help refers to ``lockprobe run`` for it."""
    groups = command.by_heading(typer.Context(command)) if isinstance(command, Command) else {"Options": command.params}
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


def test_an_option_of_one_value_that_is_given_again_is_refused_by_every_command(everything):
    for path, option, _ in declared(everything):
        if not path:
            continue  # of the shell, such as --install-completion
        command, value = everything, [] if option.is_flag else ["1"]
        for name in path.split():
            command = command.commands[name]
        words = [option.opts[0], *value, [*option.opts, *option.secondary_opts][-1], *value]
        said = ""
        try:
            command.make_context(path, words)
        except TyperException as mistake:
            said = mistake.format_message()
        except UserMistake as mistake:
            said = str(mistake)
        assert said.startswith(f"Option '{option.opts[0]}' is given 2 times") != option.multiple, path


@pytest.mark.parametrize("again", [["--box", "chain-4", "--box", "fork"], ["--seed", "1", "--seed=2"], ["--json"] * 2])
def test_what_is_given_again_is_refused_in_one_line(lockprobe, again):
    said = f"lockprobe: Option '{again[0]}' is given 2 times; it can be given only once.\n"
    assert lockprobe("run", "flips", *again) == (2, "", said)
    assert lockprobe("run", "flips", *again, "--help")[0] == 0


def test_flip_rates_are_all_played_however_they_are_given(lockprobe):
    one, each = (
        lockprobe("run", "flips", "--agent", "random", *rates, "--estimate")
        for rates in (["--p", "0,0.4"], ["--p", "0", "--p", "0.4"])
    )
    assert one == each
    assert one[0] == 0
