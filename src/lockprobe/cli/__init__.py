"""The command ``lockprobe``: each subcommand parses, calls one library function and prints."""

from __future__ import annotations

import atexit
import difflib
import gc
import io
import os
import sys
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lockprobe.foundation import formatting
from lockprobe.foundation.child_processes import safe_path

if TYPE_CHECKING:
    from typer import Typer

__all__ = ["COMMANDS", "build", "every_command", "main"]

COMMANDS = {
    "run": ("run", "run", "Play a study, or resume it, and write its report."),
    "status": ("status", "status", "Show progress, errors and cost of a study."),
    "report": ("report", "report", "Write the report of a study again, or compare studies."),
    "verify": ("verify", "verify", "Recompute a study from its records and check its results."),
    "export": ("export", "export", "Export trials as tables."),
    "import": ("import_", "take", "Import trials from study directories."),
    "replay": ("replay", "replay", "Show a finished trial, step by step or as a film."),
    "branch": ("branch", "branch", "Measure the effect of one report: fork recorded trials."),
    "serve": ("serve", "serve", "Let people take part in a study in their browser."),
    "withdraw": ("serve", "withdraw", "Delete all data of one participant."),
    "mcp": ("mcp", "mcp", "Let an agent with tools (MCP) play a study."),
    "loops": ("loops", "loops", "Find action loops in sequences, one per line."),
    "chance": ("loops", "chance", "Compute the chance level of an action loop."),
    "power": ("power", "power", "Find how many trials a given effect needs."),
    "play": ("play", "play", "Play a trial yourself in the terminal."),
    "box": ("box", "app", "List, show, check and generate boxes."),
    "list": ("list_", "app", "List agents, plants, interventions, models or measures."),
    "doctor": ("doctor", "doctor", "Check what works on this machine, or with a model."),
}
"""Name of a command -> (module, function or group in it, help)."""

_OF_ROBOT = {"rig": "Prepare a robot: calibrate, check."}
"""Name of a command that lockprobe-robot adds -> help."""


def every_command() -> list[str]:
    """The names of all commands that are installed."""
    from lockprobe.foundation.plugins import find_plugin

    return [
        *COMMANDS,
        *(name for name in _OF_ROBOT if (plugin := find_plugin("command", name)) is not None and plugin.ships),
    ]


def build(names: Iterable[str], *, listed: bool = False) -> Typer:
    """The ``lockprobe`` command with these subcommands; only their modules are imported.

    If they are only ``listed``, with a line of help each, no module is.

    Raises:
        Missing: If one is of lockprobe-robot, which is not installed.
    """
    import typer

    app = typer.Typer(
        help="A laboratory for probing the behaviour of embodied agents with lockboxes.",
        no_args_is_help=True,
        context_settings={"help_option_names": ["-h", "--help"]},
        pretty_exceptions_enable=False,
        rich_markup_mode=None,  # plain help: half the time, and any screen reader reads it
    )

    def print_version(asked: bool) -> None:
        if asked:
            from importlib.metadata import version

            print(f"lockprobe {version('lockprobe')}")
            raise typer.Exit

    asked = typer.Option(False, "--version", callback=print_version, is_eager=True, help="Print the version.")

    @app.callback()  # so that a single subcommand still has a name
    def _command(version: bool = asked) -> None:
        pass

    for name in names:
        text = COMMANDS[name][2] if name in COMMANDS else _OF_ROBOT[name]
        if listed:
            app.command(name, help=text)(lambda: None)
            continue
        from lockprobe.cli.options import Command, as_ours
        from lockprobe.foundation.plugins import docstring

        found = _subcommand(name)
        if isinstance(found, typer.Typer):
            as_ours(found)
            app.add_typer(found, name=name, help=text)
        else:
            app.command(name, cls=Command, help=docstring(found).replace("``", ""), short_help=text)(found)
    return app


def _subcommand(name: str) -> Any:
    """A subcommand: a function, or a group."""
    if name in COMMANDS:
        module, attribute, _ = COMMANDS[name]
        return getattr(import_module(f"lockprobe.cli.{module}"), attribute)
    from lockprobe.foundation.plugins import robot_plugin

    return robot_plugin("command", name, f"lockprobe {name} needs").load()


def main() -> None:
    """The ``lockprobe`` command. Exit status 2: a user's mistake, in one line; 130: Ctrl-C."""
    atexit.register(gc.freeze)  # a process that ends looks through no objects again, which takes half a second
    formatting.epoch_held = os.environ.pop("SOURCE_DATE_EPOCH", "")
    try:
        with safe_path():  # also what libraries start: glfw asks an interpreter of its own for its version
            status = _run_command()
    except KeyboardInterrupt:  # while modules are imported, or where a command has nothing to say about it
        print("lockprobe: stopped by Ctrl-C", file=sys.stderr)
        status = 130
    sys.exit(status)


def _run_command() -> int | None:
    """Parse the command line and run the command."""
    import typer
    from typer.exceptions import TyperException

    from lockprobe.foundation.errors import UserMistake

    for name in ("stdout", "stderr"):  # what goes to a closed stream is dropped; "?" for what a terminal cannot show
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115 - for the whole run
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    asked = next((word for word in sys.argv[1:] if word != "--"), "")
    try:
        known = asked in COMMANDS or asked in _OF_ROBOT
        whole = "_LOCKPROBE_COMPLETE" in os.environ  # a shell completes, which needs the options of all
        app = build([asked] if known and not whole else every_command(), listed=not (known or whole))
        status = app(standalone_mode=False)
        return status if isinstance(status, int) else None
    except UserMistake as mistake:
        return _complain(str(mistake))
    except TyperException as mistake:
        said = getattr(mistake, "format_message", mistake.__str__)()
        if said.startswith("Usage: "):  # no command is named
            print(said, file=sys.stderr)
        return _complain("" if said.startswith("Usage: ") else _error_text(said, asked))
    except typer.Abort:
        return 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        return _complain(f"{error.filename or 'writing'}: {error.strerror or error}")


def _error_text(message: str, asked: str) -> str:
    """The error message for a wrong command line, in plain words."""
    from lockprobe.foundation.validation import plain

    if message.startswith("No such command") and asked in every_command():  # a group has no such command
        known = (str(one.name or one.callback.__name__) for one in _subcommand(asked).registered_commands)
        return f"{message.rstrip('.')} of lockprobe {asked}; there are {', '.join(known)}"
    if message.startswith("No such command"):
        from lockprobe.studies.options.study_options import SHIPPED, STUDIES

        studies = (*STUDIES, *SHIPPED)  # which somebody may type where a command belongs
        names = [asked] if asked.endswith(".toml") else [*every_command(), *studies]
        meant = next(iter(difflib.get_close_matches(asked, names, n=1)), "")
        command = f"lockprobe run {meant}" if meant in studies or meant.endswith(".toml") else meant
        return f"No such command {asked!r}." + f" Did you mean {command!r}?" * bool(command)
    head, colon, rest = message.partition(": ")
    return f"{head}{colon}{plain(rest)}"


def _complain(message: str) -> int:
    if message:
        from lockprobe.foundation.terminal_text import printable

        print(printable("lockprobe: " + " ".join(message.split())), file=sys.stderr)
    return 2
