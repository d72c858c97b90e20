"""Plug-ins: additions of other packages by entry points, and classes that a user names as ``python:module:Name``.

A package adds an agent, a plant, a box, an intervention, a measure or a command by an entry point in the group of that
kind (:data:`GROUPS`); the entry point's name is the spec's.
``python:module:Name?option=value`` names a class or a function directly. Nothing is imported before it is used. An
error in it becomes one line that names the package.

What a file or a directory says is data. A ``python:`` spec runs only in a process in which a person has named it, on
the command line or as an argument in Python (:func:`allow`); where it was read is never enough. What is found is held
against what its kind needs before it is called.
"""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from inspect import cleandoc, getsource, isclass, isroutine
from operator import attrgetter
from pathlib import Path
from textwrap import dedent
from types import BuiltinFunctionType
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from lockprobe.foundation.errors import (
    BadFile,
    BadValue,
    BrokenPlugin,
    LockprobeError,
    Missing,
    UserMistake,
    kind_and_words,
)
from lockprobe.foundation.spec import Spec, arguments_from, spec_kind, spec_name, split_specs

if TYPE_CHECKING:
    from importlib.metadata import EntryPoints

Kind = Literal["agent", "box", "command", "intervention", "measure", "plant", "plant source", "tool"]

GROUPS: Mapping[Kind, str] = {
    "agent": "lockprobe.agents",
    "box": "lockprobe.boxes",
    "command": "lockprobe.commands",
    "intervention": "lockprobe.interventions",
    "measure": "lockprobe.measures",
    "plant": "lockprobe.plants",
    "plant source": "lockprobe.plant_sources",
    "tool": "lockprobe.tools",
}
"""Kind of addition -> the group of its entry points. A tool is a function that a command calls."""

ROBOT = "lockprobe-robot"
"""The other distribution of Lockprobe. What it adds ships with Lockprobe: nobody replaces it, and it may always run."""

_DIRECT = "python:"

_named: set[str] = set()
"""The ``python:`` specs that a person has named in this process."""

_closing: list[None] = []
"""Not empty where nothing of others may run now, in any thread, also of installed packages."""


def allow(*specs: str) -> None:
    """Let the ``python:`` specs in these texts run in this process, because a person has named them in this command.

    Call it with what a command line or a caller in Python gives, never with what a file or a directory says. Of agents,
    plants, boxes and measures the spec counts with its options, of interventions the class. Others are left alone.
    """
    for part in (part for spec in specs for part in (spec, *split_specs(spec))):
        if part.startswith(_DIRECT):
            _named.update((part, f"{spec_name(part)}?"))


def allowed() -> tuple[str, ...]:
    """The specs that may run here, for :func:`allow` in a process that works for this one."""
    return tuple(sorted(_named))


@contextmanager
def no_foreign_code() -> Iterator[None]:
    """Let nothing of other packages and of the user run meanwhile; what needs it is refused in one line."""
    _closing.append(None)
    try:
        yield
    finally:
        _closing.pop()


def runs_foreign_code() -> bool:
    """Whether code of installed packages may run here."""
    return not _closing


@dataclass(frozen=True, slots=True, kw_only=True)
class Plugin:
    """A class, function or object of another package, not imported yet.

    Attributes:
        name: Its name in a spec: that of the entry point, or ``python:module:Name``.
        value: Where it is, ``module:Name``.
        package: The distribution with its version; empty for ``python:``.
        spec: The spec that names it, with its options.
    """

    kind: Kind
    name: str
    value: str
    package: str = ""
    spec: str = ""

    @property
    def ships(self) -> bool:
        """Whether it is of Lockprobe's other distribution."""
        return self.package.partition(" ")[0] == ROBOT

    def load(self) -> Any:
        """Import it, if it may run here and can be found."""
        if not (self.ships or runs_foreign_code()):
            raise BadValue(self.kind, self.name, "one that ships with Lockprobe: no other code runs here")
        module, _, path = self.value.partition(":")
        if not self.package:
            named = f"{self.name}?" if self.kind == "intervention" else self.spec or self.name
            if named not in _named:
                expected = (
                    "--allow with it in this command (in Python: lockprobe.foundation.plugins.allow): "
                    "what a file or a directory names is data, and is not run"
                )
                raise BadValue(self.kind, self.spec or self.name, expected)
            if (here := str(Path.cwd())) not in sys.path:
                sys.path.append(here)  # last: what lies beside the module hides nothing
        try:
            found = attrgetter(path)(importlib.import_module(module))
        except (KeyboardInterrupt, GeneratorExit):
            raise
        except BaseException as error:  # also the SystemExit of a module that is a program
            if self.package:
                raise BrokenPlugin(self.kind, self.name, self.package, error) from error
            said = str(error) if isinstance(error, ImportError | AttributeError) else kind_and_words(error)
            expected = f"python:module:Name of an importable class or function ({said})"
            raise BadValue(self.kind, self.name, expected) from error
        return found

    def make(self, *, is_one: Callable[[Any], bool], expected: str) -> Any:
        """Call it with its options, read by the annotation or the default of each argument.

        An object that cannot be called is returned as it is. ``is_one`` says whether what was found, which is not
        called yet, is of the kind, which ``expected`` describes.
        """
        found, options = self.load(), Spec.parse(self.spec, self.kind).options
        with self.guarded():
            if not is_one(found):
                raise BadValue(self.kind, self.name, expected)
            if callable(found):
                return found(**arguments_from(found, self.name, options))
        if options:
            raise BadValue(self.kind, self.name, f"no options: it is a {type(found).__name__}")
        return found

    @contextmanager
    def guarded(self) -> Iterator[None]:
        """Run code of the plug-in, and turn its errors into one line. Lockprobe's own errors pass unchanged."""
        try:
            yield
        except (LockprobeError, KeyboardInterrupt, GeneratorExit):
            raise
        except BaseException as error:
            raise BrokenPlugin(self.kind, self.name, self.package, error) from error


class Listed(NamedTuple):
    """A plug-in of an installed package in a list: what it says of itself; unused, without ``found``, why that is."""

    name: str
    package: str
    what: str
    found: Any = None


def plugin_names(kind: Kind) -> tuple[str, ...]:
    """The names that packages of others add, sorted. Nothing is imported."""
    points = _points(kind)
    return tuple(sorted({point.name for point in points} - {point.name for point in points if _ships(point)}))


def docstring(thing: object) -> str:
    """What a class, a function or an object's class says of itself; empty if it says nothing.

    ``python -OO`` drops docstrings (and ``dataclass`` then makes some up): they are read from the source there.
    """
    if sys.flags.optimize < 2 or (isroutine(thing) and thing.__doc__):
        return cleandoc(thing.__doc__ or "")
    kind = thing if isclass(thing) or isroutine(thing) else type(thing)
    try:
        (written,) = ast.parse(dedent(getsource(kind))).body
        return ast.get_docstring(written) or ""  # type: ignore[arg-type]  # a class or a function
    except (OSError, SyntaxError, TypeError):  # without a source
        return ""


def first_line(thing: object) -> str:
    """The first line of that."""
    return docstring(thing).partition("\n")[0]


def has_methods(found: object, *names: str) -> bool:
    """Whether something is a class with these methods."""
    return isinstance(found, type) and all(callable(getattr(found, name, None)) for name in names)


def is_own_function(found: object) -> bool:
    """Whether something is a function that somebody wrote in Python, no class and no function of Python itself."""
    return callable(found) and not isinstance(found, type | BuiltinFunctionType)


def find_plugin(kind: Kind, spec: str) -> Plugin | None:
    """Find ``python:module:Name`` or an entry point by its spec, without an import; None if it does not exist."""
    name = spec_name(spec)
    if name.startswith(_DIRECT):
        return Plugin(kind=kind, name=name, value=name.removeprefix(_DIRECT), spec=spec)
    points = [point for point in _points(kind) if point.name == name]
    points = [point for point in points if _ships(point)] or points
    if len({point.value for point in points}) > 1:
        raise BadValue(kind, name, f"a name from only one package, not from {' and '.join(map(_package, points))}")
    if not points:
        return None
    return Plugin(kind=kind, name=name, value=points[0].value, package=_package(points[0]), spec=spec)


def robot_plugin(kind: Kind, name: str, what: str) -> Plugin:
    """What lockprobe-robot adds under a name, or a spec that begins with it, which is never that of another package.

    ``what`` needs it, with its verb, for the message: ``films need``.
    """
    plugin = find_plugin(kind, name)
    if plugin is None or not plugin.ships:
        raise Missing(f"{what} the package {ROBOT}", "pip install 'lockprobe[twin]'")
    return plugin


def listed_plugins(
    kind: Kind, own: Collection[str] = (), check: Callable[[str, Any], object] = lambda name, found: None
) -> list[Listed]:
    """All plug-ins of one kind, imported; unusable ones are included with the reason.

    No package can add Lockprobe's ``own`` names. ``check`` raises a user's mistake if an object cannot be used.
    """
    rows = []
    for name in plugin_names(kind):
        package = " and ".join(sorted({_package(point) for point in _points(kind) if point.name == name}))
        try:
            if name in own or (plugin := find_plugin(kind, name)) is None:
                raise BadValue(kind, name, "a different name: Lockprobe itself uses this one")
            check(name, found := plugin.load())
            rows.append(Listed(name, package, first_line(found), found))
        except UserMistake as mistake:
            rows.append(Listed(name, package, f"Cannot be used. {mistake}"))
    return rows


def plugin_name_of(kind: Kind, found: type[Any]) -> str:
    """The name under which an installed package has a class; ``python:module:Name`` if none has it."""
    for point in _points(kind):
        if point.value.partition(":")[0].partition(".")[0] == found.__module__.partition(".")[0]:  # it may re-export it
            with suppress(UserMistake):
                if Plugin(kind=kind, name=point.name, value=point.value, package="?").load() is found:
                    return str(point.name)
    return f"{_DIRECT}{found.__module__}:{found.__qualname__}"


def refuse_python(path: Path, what: str, specs: Iterable[object]) -> None:
    """Refuse ``python:`` specs in a file, which would run code, also within conditions."""
    for spec in specs:
        if isinstance(spec, str) and any(spec_kind(part) == "python" for part in split_specs(spec)):
            raise BadFile(path, f"{what}: {spec} would run code; name it on the command line with --{what}")


def _points(kind: Kind) -> EntryPoints:
    return _points_on(kind, tuple(sys.path))


@lru_cache(maxsize=32)
def _points_on(kind: Kind, path: tuple[str, ...]) -> EntryPoints:
    """The entry points of a kind on an import path, cached because the search takes 15 ms."""
    from importlib.metadata import entry_points  # a tenth of a second, which most commands need not wait for

    return entry_points(group=GROUPS[kind])


def _ships(point: Any) -> bool:
    return point.dist is not None and str(point.dist.name) == ROBOT


def _package(point: Any) -> str:
    return "another package" if point.dist is None else f"{point.dist.name} {point.dist.version}"
