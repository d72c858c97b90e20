"""Help under headings: what most people need first, everything once, and what another command explains by name."""

import re

import typer

from lockprobe.cli import build
from lockprobe.cli.command import AS_RUN

COMMANDS = ("run", "serve", "mcp", "power", "play", "branch")


def of(name):
    command = typer.main.get_command(build([name])).commands[name]
    return command, command.by_heading(typer.Context(command))


def test_run_shows_the_ten_options_first_that_most_people_need(lockprobe):
    said = lockprobe("run", "--help")[1]
    first, *headings = re.split(r"\n\n(?=\S)", said.partition("\nOptions:\n")[2])
    assert len(re.findall(r"^  --", first, re.MULTILINE)) == 10
    assert [text.partition(":\n")[0] for text in headings] == [
        "The study", "Reports and conditions", "Running", "Hosted models"]  # fmt: skip


def test_every_option_is_under_one_heading():
    for name in COMMANDS:
        command, headings = of(name)
        listed = [option.name for options in headings.values() for option in options]
        assert sorted(listed) == sorted([*(option.name for option in command.params), "help"])


def test_what_run_explains_is_named_by_the_others_and_parsed_by_them(lockprobe):
    shown = {option.name: option for options in of("run")[1].values() for option in options}
    for name in COMMANDS[1:]:
        referred = of(name)[1][AS_RUN]
        _, _, end = lockprobe(name, "--help")[1].partition(f"{AS_RUN}:\n")
        assert end.replace(",", " ").split() == [option.opts[0] for option in referred]
        for option in referred:
            same = shown[option.name]
            assert (option.opts, option.secondary_opts, option.help, option.multiple, option.default) == (
                same.opts, same.secondary_opts, same.help, same.multiple, same.default)  # fmt: skip
