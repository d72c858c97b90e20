"""Nouns and verbs: parse, call one library function, print."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path

import typer
from typer.exceptions import TyperException

from lockprobe.errors import UserMistake, printable

__all__ = ["COMMANDS", "build", "main"]

COMMANDS = {
    "run": ("run", "run", "Play a study, or resume it, and write its report."),
    "status": ("status", "status", "What is done, owed and failed, and what it has cost."),
    "report": ("results", "report", "Write the report of a study again."),
    "export": ("results", "export", "Tidy steps, one row a step; logs for Inspect AI; a dataset of people."),
    "import": ("gather", "take", "Take in trials of Inspect logs, people's datasets, other directories of a study."),
    "replay": ("replay", "replay", "A finished trial, step by step, truth beside told, or as a film."),
    "serve": ("serve", "serve", "Let people take part in a study, on a page in their browser."),
    "loops": ("loops", "loops", "Action loops in sequences, one sequence a line."),
    "chance": ("chance", "chance", "The chance level of an action loop."),
    "detectors": ("detectors", "detectors", "Other loop detectors: what each flags, and how often it is wrong."),
    "fit": ("fit", "fit", "Which simple mechanism predicts an agent's choices, and how well."),
    "audit": ("audit", "audit", "Is each test right? Error rates and power on simulated agents with known truth."),
    "power": ("audit", "power", "How many trials a stated effect needs."),
    "play": ("play", "play", "Play a trial yourself in the terminal; then see what was true, and how others did."),
    "box": ("boxes", "app", "Boxes: list, show, solve, generate."),
    "agents": ("agents", "agents", "The agents there are."),
    "plants": ("agents", "plants", "What can be acted on: rules, a simulated box, a robot."),
    "models": ("agents", "models", "Language models on this machine."),
    "doctor": ("agents", "doctor", "What works on this machine, and what to do about the rest."),
}
"""Name -> (module, function or group in it, help)."""


def build(names: Iterable[str]) -> typer.Typer:
    """The command with these subcommands; only their modules are imported."""
    app = typer.Typer(
        help="A laboratory for probing the behaviour of embodied agents with lockboxes.",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
    )
    app.callback()(lambda: None)  # so that a single subcommand still has a name
    for name in names:
        module, attribute, text = COMMANDS[name]
        found = getattr(import_module(f"lockprobe.cli.{module}"), attribute)
        if isinstance(found, typer.Typer):
            app.add_typer(found, name=name, help=text)
        else:
            app.command(name, help=text)(found)
    return app


def main() -> None:
    """The ``lockprobe`` command. Exit status 2: a user's mistake, in one line; 130: Ctrl-C."""
    _writable_streams()
    asked = sys.argv[1] if len(sys.argv) > 1 else ""
    try:
        status = build([asked] if asked in COMMANDS else COMMANDS)(standalone_mode=False)
    except UserMistake as mistake:
        status = _complain(str(mistake))
    except TyperException as mistake:
        message = getattr(mistake, "format_message", mistake.__str__)()
        status = _complain(message.replace("Value error, ", "").replace("Input should be", "it should be"))
    except (KeyboardInterrupt, typer.Abort):
        status = 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = 0
    except OSError as error:
        status = _complain(f"{error.filename or 'writing'}: {error.strerror or error}")
    sys.exit(status)


def _writable_streams() -> None:
    """A closed stream swallows what is printed; a character that a terminal cannot show becomes a question mark."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115 - for the whole run
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def _complain(message: str) -> int:
    if message:
        print("lockprobe: " + printable(" ".join(message.split())), file=sys.stderr)
    return 2
