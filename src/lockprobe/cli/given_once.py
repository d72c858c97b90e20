"""An option of one value is given once: of two values one would be dropped, and nobody would be told."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from typer.core import TyperCommand

from lockprobe.foundation.docstrings import docstring

if TYPE_CHECKING:
    from typer import Typer


class GivenOnce(TyperCommand):
    """A command that refuses an option of one value, or a flag, that is given again."""

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


def as_ours(group: Typer) -> None:
    """Make :class:`GivenOnce` of all commands of a group that have no class of their own, and find their help."""
    for command in group.registered_commands:
        command.help = command.help or docstring(command.callback)
        if command.cls is TyperCommand:
            command.cls = GivenOnce
    for part in group.registered_groups:
        if part.typer_instance is not None:
            as_ours(part.typer_instance)
