"""Help that prints options under headings, and leaves out those that ``lockprobe run --help`` explains."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from lockprobe.cli.given_once import GivenOnce

AS_RUN = "The same as for lockprobe run, whose --help explains them"
"""The heading of the options that a command accepts and does not explain."""

_ARGUMENTS, _OPTIONS = "Arguments", "Options"

Command = TypeVar("Command", bound=Callable[..., None])


def under_headings(headings: Mapping[str, str]) -> Callable[[Command], Command]:
    """Print options of a command under these headings; the others stay under ``Options``.

    Args:
        headings: Heading -> the names of its options, in their order, with spaces between.
    """

    def give(command: Command) -> Command:
        earlier = getattr(command, "headings", {})
        command.headings = {**headings, **earlier}  # type: ignore[attr-defined]
        return command

    return give


class Headed(GivenOnce):
    """A command whose help has headings."""

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
                    formatter.write_text(as_run(options))
                else:
                    formatter.write_dl([row for one in options if (row := one.get_help_record(context))])


def as_run(options: list[Any]) -> str:
    """The names of options that a command accepts as ``lockprobe run`` does."""
    return ", ".join(one.opts[0] for one in options)
