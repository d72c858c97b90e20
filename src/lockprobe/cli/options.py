"""The command-line options of ``lockprobe run`` and ``lockprobe serve``."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import typer

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.spec import spec_kind
from lockprobe.interventions.flip import FlipKind
from lockprobe.studies.study_options import StudyOptions, parse_p

__all__ = [
    "Again",
    "Allow",
    "AsJson",
    "Batch",
    "Budget",
    "Camera",
    "ClusterAt",
    "Connections",
    "EstimateOnly",
    "Name",
    "Out",
    "Retries",
    "ShardOf",
    "Timeout",
    "Workers",
    "WriteReport",
    "permit",
    "with_study_options",
]

_STUDY = "The study; mechanisms.toml comes with the package."
_BUDGET = "The most that the study may cost in US dollars, earlier runs included; it is never exceeded."
_BATCH = "Use the provider's batch interface: it is cheaper and takes hours instead of seconds."
_ESTIMATE = "Only estimate the cost; call no model and write nothing."
_REPORT = "Write the report; `lockprobe report DIR` does it later."
_AGAIN = "Replay trials that ended without a usable reply, or as a refusal; earlier records stay in the file (nothing)."
_RETRIES = "How often a request without an answer is made again."
_SHARD = "Play only part i of n of the trials, for example 3/16; `lockprobe import` joins the directories (all)."
_CLUSTER = "A Ray cluster on whose processors agents and plants that ship are played; see docs/cluster.md (none)."
_CAMERA = "For --plant manual: pictures tell the truth; a folder in which you save them, or webcam (a person tells it)."
_ALLOW = "Code of yours that the directory names, as python:MODULE:NAME; it runs only if named; may be repeated (none)."
_WORKERS = "Processes for local models and simulated plants (one per core)."


def _directory(path: str) -> Path:
    """Nothing is the current directory only for those who write a dot."""
    if not path:
        raise BadValue("out", path, "a directory")
    return Path(path)


Name = Annotated[str, typer.Argument(metavar="flips|modalities|why|suite-1|FILE.toml", help=_STUDY)]
Out = Annotated[Path | None, typer.Option(metavar="DIR", parser=_directory, help="Directory of the study.")]
Workers = Annotated[int | None, typer.Option(min=1, help=_WORKERS)]
Connections = Annotated[int, typer.Option(min=1, help="Requests to providers in progress at once.")]
Timeout = Annotated[float, typer.Option(help="Seconds after which a hanging request is made again.")]
Camera = Annotated[str | None, typer.Option("--camera", metavar="FOLDER|webcam", help=_CAMERA)]
ClusterAt = Annotated[str | None, typer.Option("--cluster", metavar="auto|HOST:PORT", help=_CLUSTER)]
ShardOf = Annotated[str | None, typer.Option("--shard", metavar="i/n", help=_SHARD)]
Retries = Annotated[int, typer.Option(help=_RETRIES)]
Budget = Annotated[float | None, typer.Option(metavar="DOLLARS", help=_BUDGET)]
Batch = Annotated[bool, typer.Option("--batch", help=_BATCH)]
WriteReport = Annotated[bool, typer.Option("--report/--no-report", help=_REPORT)]
EstimateOnly = Annotated[bool, typer.Option("--estimate", help=_ESTIMATE)]
Again = Annotated[str | None, typer.Option(metavar="reply|refusal", help=_AGAIN)]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object a line.")]
Allow = Annotated[list[str] | None, typer.Option("--allow", metavar="SPEC", help=_ALLOW)]


def permit(specs: Iterable[str] | None) -> None:
    """Let code of ``--allow`` run.

    Raises:
        BadValue: If it names none.
    """
    for spec in specs or ():
        if spec_kind(spec) != "python":
            raise BadValue("allow", spec, "python:MODULE:NAME")
        allow(spec)


def with_study_options(*, without: Iterable[str] = ()) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command the options of a study, except ``without``, in front of its own options.

    The command gets those that the user gave as ``asked``.
    """
    names = [name for name in StudyOptions.model_fields if name not in {"study", *without}]

    def give(command: Callable[..., None]) -> Callable[..., None]:
        hints = get_type_hints(command, include_extras=True)
        own = [
            parameter.replace(annotation=hints[name])
            for name, parameter in inspect.signature(command).parameters.items()
            if name != "asked"
        ]
        options = [
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=_option(name))
            for name in names
        ]

        def run(*what: Any, **given: Any) -> None:
            given |= dict(zip([own[0].name], what, strict=False))
            asked = {name: given.pop(name, None) for name in names}
            if asked.get("p") is not None:
                asked["p"] = parse_p(asked["p"])
            command(asked={name: value for name, value in asked.items() if value not in (None, [])}, **given)

        run.__name__, run.__doc__ = command.__name__, command.__doc__
        rest = [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in own[1:]]
        run.__signature__ = inspect.Signature([own[0], *options, *rest])  # type: ignore[attr-defined]
        return run

    return give


def _option(name: str) -> Any:
    """An option of a study as one of a command line: lists are repeated, flip rates have commas between."""
    field = StudyOptions.model_fields[name]
    kind, words = _kind(field.annotation), field.description
    if kind is bool:
        flag = f"--{name.replace('_', '-')}" if field.default is False else f"--{name}/--no-{name}"
        return Annotated[bool | None, typer.Option(flag, help=words)]
    return Annotated[kind | None, typer.Option(help=words)]


def _kind(annotation: Any) -> Any:
    """What a command line takes for a type of a field."""
    (kind,) = {part for part in get_args(annotation) if part is not NoneType} or {annotation}
    kind = _bare(kind)
    if get_origin(kind) is list:
        return str if _bare(get_args(kind)[0]) is float else list[str]
    if get_origin(kind) is Union:
        return str  # a box, by its name or path
    if get_origin(kind) is Literal:
        return str if kind == FlipKind else kind  # the flip says itself which kinds there are
    return kind


def _bare(kind: Any) -> Any:
    """A type without its annotations."""
    return get_args(kind)[0] if get_origin(kind) is Annotated else kind
