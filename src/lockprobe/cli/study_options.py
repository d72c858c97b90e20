"""The options that describe a study, on the command line: one table, from which every command takes its own."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable
from types import NoneType
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import typer

from lockprobe.cli.options import AS_RUN, under_headings, with_brackets
from lockprobe.foundation.plugins import docstring
from lockprobe.studies.options.study_options import StudyOptions

_STUDY = "The study; mechanisms.toml comes with the package."

Name = Annotated[str, typer.Argument(metavar="flips|modalities|why|looks|FILE.toml", help=_STUDY)]


FILE_ONLY = frozenset({"contrasts", "name"})
"""What a study file and Python say and a command line does not: a table, and the name with which keys begin."""


def study_help(name: str, here: str) -> str:
    """What an option of a study means, with what holds in one command in place of its default.

    >>> study_help("seed", "drawn")
    'Seed of everything (drawn).'
    """
    words = re.sub(r" \([^()]*\)\.$", "", str(StudyOptions.model_fields[name].description))
    return with_brackets(words, here)


def with_study_options(
    *, only: Iterable[str] = (), without: Iterable[str] = (), explained: bool = False
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command options of a study, in front of its own; it receives those that are given as ``asked``.

    Args:
        only: Their names; all if there are none.
        without: Names to leave out.
        explained: Whether the help of the command explains them, as that of ``lockprobe run`` alone does.
    """
    names = [name for name in only or StudyOptions.model_fields if name not in {"study", *FILE_ONLY, *without}]

    def give(command: Callable[..., None]) -> Callable[..., None]:
        hints = get_type_hints(command, include_extras=True)
        own = [
            parameter.replace(annotation=hints[name], kind=inspect.Parameter.KEYWORD_ONLY)
            for name, parameter in inspect.signature(command).parameters.items()
            if name != "asked"
        ]
        options = [
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=_option(name))
            for name in names
        ]

        def run(*what: Any, **given: Any) -> None:
            given |= dict(zip((parameter.name for parameter in own), what, strict=False))
            asked = {name: given.pop(name, None) for name in names}
            command(asked={name: value for name, value in asked.items() if value not in (None, [])}, **given)

        run.__name__, run.__doc__ = command.__name__, docstring(command)
        run.__signature__ = inspect.Signature([*own, *options])  # type: ignore[attr-defined]
        return run if explained else under_headings({AS_RUN: " ".join(names)})(run)

    return give


def _option(name: str) -> Any:
    """An option of a study as one of a command line: lists are repeated."""
    field = StudyOptions.model_fields[name]
    kind, *_ = [part for part in get_args(field.annotation) if part is not NoneType] or [field.annotation]
    kind = get_args(kind)[0] if get_origin(kind) is Annotated else kind
    if kind is bool:
        flag = f"--{name.replace('_', '-')}" if field.default is False else f"--{name}/--no-{name}"
        return Annotated[bool | None, typer.Option(flag, help=field.description)]
    kind = list[str] if get_origin(kind) is list else kind
    return Annotated[kind | None, typer.Option(help=field.description, min=0 if name == "seed" else None)]
