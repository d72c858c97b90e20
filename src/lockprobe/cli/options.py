"""What commands share: options that are spelled and explained in one way, and help under headings.

What a command says of an option in brackets, the default or what it means there, may differ. The options that describe
a study are those of :class:`lockprobe.studies.options.study_options.StudyOptions`; see ``lockprobe.cli.study_options``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer
from typer.core import TyperCommand

from lockprobe.foundation.plugins import docstring

if TYPE_CHECKING:
    from typer import Typer

BOX = "A box by name, random-N-SEED, or a TOML file."
OUT = "Where the result is written."
PLANT = "What is acted on: a plant that lockprobe list plants lists, with options as in twin?looks=varied."

_ALLOW = "Code of yours that the directory names, as python:MODULE:NAME; it runs only if named; may be repeated (none)."
_BUDGET = "The most that the study may cost in US dollars, earlier runs included; it is never exceeded."
_CLUSTER = "A Ray cluster on whose processors agents and plants that ship are played; see docs/cluster.md (none)."


def with_brackets(text: str, here: str) -> str:
    """The text of an option with what holds in one command.

    >>> with_brackets("Number of joints.", "4")
    'Number of joints (4).'
    """
    return f"{text.removesuffix('.')} ({here})."


def _everything(context: typer.Context, asked: bool) -> None:
    """Print the whole help of a command whose ``--help`` is one screen."""
    if asked:
        context.meta["everything"] = True
        typer.echo(context.get_help())
        context.exit()


Allow = Annotated[list[str] | None, typer.Option("--allow", metavar="SPEC", help=_ALLOW)]
AsJson = Annotated[bool, typer.Option("--json", help="JSON: one object, or one a line.")]
Box = Annotated[str, typer.Option(help=BOX)]
Budget = Annotated[float | None, typer.Option(metavar="DOLLARS", help=_BUDGET)]
ClusterAt = Annotated[str | None, typer.Option("--cluster", metavar="auto|HOST:PORT", help=_CLUSTER)]
Connections = Annotated[int, typer.Option(min=1, help="Requests to providers in progress at once.")]
Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")]
Out = Annotated[Path | None, typer.Option(metavar="DIR", help=with_brackets(OUT, "lockprobe-runs/STUDY-HASH"))]
Retries = Annotated[int, typer.Option(help="How often a request without an answer is made again.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of everything.")]
HelpAll = Annotated[
    bool, typer.Option("--help-all", is_eager=True, callback=_everything, help="Explain every option, in full.")
]
Timeout = Annotated[float, typer.Option(help="Seconds after which a hanging request is made again.")]
Workers = Annotated[int | None, typer.Option(min=1, help="Processes (one per core, at most 8).")]


AS_RUN = "The same as for lockprobe run, whose --help-all explains them"
"""The heading of the options that a command accepts and does not explain."""

Function = TypeVar("Function", bound=Callable[..., None])


def under_headings(headings: Mapping[str, str]) -> Callable[[Function], Function]:
    """Print options of a command under these headings; the others stay under ``Options``.

    Args:
        headings: Heading -> the names of its options, in their order, with spaces between.
    """

    def give(function: Function) -> Function:
        earlier = getattr(function, "headings", {})
        function.headings = {**headings, **earlier}  # type: ignore[attr-defined]
        return function

    return give


class Command(TyperCommand):
    """A command whose help has headings, and that refuses an option of one value, or a flag, that is given again.

    Of two values one would be dropped, and nobody would be told. With ``--help-all``, ``--help`` is one screen: the
    first two paragraphs, the first words of each option of the first heading, and the names of the others.
    """

    def parse_args(self, context: Any, args: list[str]) -> list[str]:
        """Parse words in a context of Click's, which come back empty."""
        given = self.make_parser(context).parse_args(args=list(args))[2]
        if not (context.resilient_parsing or any(one.is_eager for one in given)):  # nor while completing, nor for help
            for one in given:
                if one.param_type_name == "option" and not one.multiple and given.count(one) > 1:
                    context.fail(
                        f"Option {one.opts[0]!r} is given {given.count(one)} times; it can be given only once."
                    )
        return super().parse_args(context, args)

    def by_heading(self, context: Any) -> dict[str, list[Any]]:
        """Heading -> its arguments or options, in the order in which help lists them."""
        headings: Mapping[str, str] = getattr(self.callback, "headings", {})
        left = {option.name: option for option in self.get_params(context)}
        found = {
            "Arguments": [left.pop(one) for one in list(left) if left[one].param_type_name == "argument"],
            "Options": [],
            **{heading: [left.pop(one) for one in names.split()] for heading, names in headings.items()},
        }
        found["Options"] += left.values()
        return {heading: options for heading, options in found.items() if options}

    def in_short(self, context: Any) -> bool:
        """Whether help is to be one screen."""
        return "everything" not in context.meta and any(one.name == "help_all" for one in self.params)

    def format_help_text(self, context: Any, formatter: Any) -> None:
        """Write what the command does in a context of Click's with its formatter."""
        whole = self.help
        if whole and self.in_short(context):
            self.help = "\n\n".join(whole.split("\n\n")[:2])
        super().format_help_text(context, formatter)
        self.help = whole

    def format_options(self, context: Any, formatter: Any) -> None:
        """Write the options in a context of Click's with its formatter."""
        short = self.in_short(context)
        for heading, options in self.by_heading(context).items():
            with formatter.section(heading):
                if heading == AS_RUN or (short and heading not in ("Arguments", "Options")):
                    formatter.write_text(", ".join(one.opts[0] for one in options))
                    continue
                rows = [row for one in options if (row := one.get_help_record(context))]
                first = [(names, re.split(r" \(|; |\. ", said)[0].removesuffix(".")) for names, said in rows]
                formatter.write_dl(first if short else rows)


def as_ours(group: Typer) -> None:
    """Make :class:`Command` of all commands of a group that have no class of their own, and find their help."""
    for command in group.registered_commands:
        command.help = command.help or docstring(command.callback)
        if command.cls is TyperCommand:
            command.cls = Command
    for part in group.registered_groups:
        if part.typer_instance is not None:
            as_ours(part.typer_instance)
