"""Nouns and verbs: parse, call one library function, print."""

from __future__ import annotations

import os
import sys

import typer
from typer.exceptions import TyperException

from lockprobe.cli import agents, boxes, loops, results, run
from lockprobe.errors import UserMistake

__all__ = ["app", "main"]

app = typer.Typer(
    help="A laboratory for probing the behaviour of embodied agents with lockboxes.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command("run", help="Play a study, or resume it, and write its report.")(run.run)
app.command("status", help="What is done, owed and failed.")(results.status)
app.command("report", help="Write the report of a study again.")(results.report)
app.command("export", help="Tidy steps, one row a step.")(results.export)
app.command("replay", help="A finished trial, step by step, truth beside told.")(results.replay)
app.command("loops", help="Action loops in sequences, one sequence a line.")(loops.loops)
app.command("chance", help="The chance level of an action loop.")(loops.chance)
app.add_typer(boxes.app, name="box", help="Boxes: list, show.")
app.command("agents", help="The agents there are.")(agents.agents)
app.add_typer(agents.models, name="models", help="Language models on this machine.")
app.command("doctor", help="What works on this machine, and what to do about the rest.")(agents.doctor)


def main() -> None:
    """The ``lockprobe`` command. A user's mistake is one line and exit status 2; Ctrl-C is 130."""
    try:
        status = app(standalone_mode=False)
    except UserMistake as mistake:
        status = _complain(str(mistake))
    except TyperException as mistake:
        status = _complain(getattr(mistake, "format_message", mistake.__str__)())
    except (KeyboardInterrupt, typer.Abort):
        status = 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = 0
    sys.exit(status)


def _complain(message: str) -> int:
    print("lockprobe: " + " ".join(message.split()), file=sys.stderr)
    return 2
