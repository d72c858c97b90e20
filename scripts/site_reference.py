"""The reference pages of the site: every command from its options, every public name from its docstring."""

from __future__ import annotations

import html
import re
from typing import TYPE_CHECKING, Any

import lockprobe
from lockprobe.cli import build, every_command
from lockprobe.cli.headings import AS_RUN, Headed, as_run

if TYPE_CHECKING:
    from collections.abc import Iterator

NAMES = {
    "Play": "run_trial study Study run_study",
    "Read": "load results tidy trial_rows",
    "Compute without a study": "propagate population",
    "Boxes": "box Lockbox Joint",
    "Records": "Trial Step Percept Decision Situation Snapshot",
    "What your own package implements": "Agent Policy Plant Channel Prompt Memory Actuator",
    "Errors": "LockprobeError UserMistake BadValue TrialFault",
}
"""Heading -> the public names of ``lockprobe`` below it."""

OPTIONS = {
    "lockprobe.studies.options.study_options.StudyOptions": "Options of study",
    "lockprobe.studies.options.trial_options.TrialOptions": "Options of run_trial",
}
"""What holds the options of two functions -> its heading."""

COMMANDS_HEAD = """# Command reference

Every command with its arguments and options, as `--help` prints them. [Commands](../docs/commands.md) says in one line
what each is for. Exit status 0 is success, 2 a mistake in one line, 130 Ctrl-C.
"""

API_HEAD = """# Python reference

What `import lockprobe` offers. [Extending](../docs/extending.md) shows how the parts fit.
"""

TESTING = """# Testing reference

What `lockprobe.testing` offers to the tests of a package that extends Lockprobe
([Extending](../docs/extending.md#tests)).

::: lockprobe.testing
    options:
      show_root_heading: false
      show_root_toc_entry: false
      show_docstring_description: false
"""


def pages() -> dict[str, str]:
    """The pages, by their path in the site."""
    return {
        "reference/commands.md": COMMANDS_HEAD + "".join(_commands()),
        "reference/python.md": API_HEAD + "".join(_names()),
        "reference/testing.md": TESTING,
    }


def _commands() -> Iterator[str]:
    import typer

    group: Any = typer.main.get_command(build(every_command()))
    for name in every_command():
        command = group.commands[name]
        yield f"\n## lockprobe {name}\n{_described(command, f'lockprobe {name}')}"
        for part, inner in getattr(command, "commands", {}).items():
            yield f"\n### lockprobe {name} {part}\n{_described(inner, f'lockprobe {name} {part}')}"


def _described(command: Any, name: str) -> str:
    """What a command does, how it is called, and its options."""
    context = command.make_context(name, [], resilient_parsing=True)
    usage = " ".join([name, *command.collect_usage_pieces(context)])
    told = "\n\n".join(" ".join(part.split()) for part in (command.help or "").split("\n\n"))
    said = f"\n{html.escape(told, quote=False)}\n\n```text\n{usage}\n```\n"
    headings = command.by_heading(context) if isinstance(command, Headed) else {"Options": command.params}
    for heading, options in headings.items():
        rows = [row for one in options if one.name != "help" and (row := one.get_help_record(context))]
        if heading == AS_RUN:
            said += f"\n[{heading}](#lockprobe-run): `{as_run(options)}`.\n"
        elif rows:
            table = "".join(f"| `{left}` | {_cell(right)} |\n" for left, right in rows)
            said += f"\n| {heading} | meaning |\n|---|---|\n{table}"
    return said


def _cell(text: str) -> str:
    """Text that is safe in a cell of a table."""
    return re.sub(r"([|*_])", r"\\\1", html.escape(" ".join(text.split()), quote=False))


def _names() -> Iterator[str]:
    for heading, names in NAMES.items():
        yield f"\n## {heading}\n"
        for name in names.split():
            home = getattr(lockprobe, name)
            yield _documented(f"{home.__module__}.{home.__name__}", f"lockprobe.{name}", name)
    yield "\n## Options\n"
    for path, heading in OPTIONS.items():
        yield _documented(path, heading, heading)


def _documented(path: str, heading: str, label: str) -> str:
    return f"\n::: {path}\n    options:\n      heading: {heading}\n      toc_label: {label}\n"
