"""What every command shares: its help under headings, each option given once, and the directory of a study."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer
from typer.core import TyperCommand

from lockprobe.foundation.plugins import docstring

if TYPE_CHECKING:
    from typer import Typer

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")]

AS_RUN = "The same as for lockprobe run, whose --help explains them"
"""The heading of the options that a command accepts and does not explain."""

_ARGUMENTS, _OPTIONS = "Arguments", "Options"

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

    Of two values one would be dropped, and nobody would be told.
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
            _ARGUMENTS: [left.pop(one) for one in list(left) if left[one].param_type_name == "argument"],
            _OPTIONS: [],
            **{heading: [left.pop(one) for one in names.split()] for heading, names in headings.items()},
        }
        found[_OPTIONS] += left.values()
        return {heading: options for heading, options in found.items() if options}

    def format_options(self, context: Any, formatter: Any) -> None:
        """Write the options in a context of Click's with its formatter."""
        for heading, options in self.by_heading(context).items():
            with formatter.section(heading):
                if heading == AS_RUN:
                    formatter.write_text(", ".join(one.opts[0] for one in options))
                else:
                    formatter.write_dl([row for one in options if (row := one.get_help_record(context))])


def as_ours(group: Typer) -> None:
    """Make :class:`Command` of all commands of a group that have no class of their own, and find their help."""
    for command in group.registered_commands:
        command.help = command.help or docstring(command.callback)
        if command.cls is TyperCommand:
            command.cls = Command
    for part in group.registered_groups:
        if part.typer_instance is not None:
            as_ours(part.typer_instance)
