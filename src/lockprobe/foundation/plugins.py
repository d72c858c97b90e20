"""Plug-ins: additions of other packages by entry points, and classes that a user names as ``python:module:Name``.

A package adds an agent, a plant, a box, an intervention or a measure by an entry point in the group of that kind
(:data:`GROUPS`); the entry point's name is the spec's. Commands and tools are those of lockprobe-robot alone.
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
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from inspect import cleandoc, getsource, isclass, isroutine
from operator import attrgetter
from pathlib import Path
from textwrap import dedent
from types import BuiltinFunctionType
from typing import Any, Literal, NamedTuple

from lockprobe.foundation.errors import BadValue, BrokenPlugin, LockprobeError, Missing, UserMistake
from lockprobe.foundation.spec import Spec, arguments_from, spec_name, split_specs

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


@dataclass(frozen=True, slots=True)
class Plugin:
    """A class, function or object of another package, not imported yet.

    Attributes:
        name: Its name in a spec: that of the entry point, or ``python:module:Name``.
        value: Where it is, ``module:Name``; empty if several packages have the name.
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
        if not self.value:
            raise BadValue(self.kind, self.name, f"a name from only one package, not from {self.package}")
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
        with self.guarded():
            return attrgetter(path)(importlib.import_module(module))

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

    def guarded(self) -> AbstractContextManager[None]:
        """Run code of the plug-in (:func:`guarded`)."""
        return guarded(self.kind, self.name, self.package)


@contextmanager
def guarded(kind: str, name: str, package: str = "") -> Iterator[None]:
    """Run code of others, and turn its errors into one line, also the SystemExit of a program.

    Lockprobe's own errors, Ctrl-C and the end of the task pass unchanged.
    """
    try:
        yield
    except BaseException as error:
        from asyncio import CancelledError  # which takes longer than help, and only an error needs

        if isinstance(error, LockprobeError | KeyboardInterrupt | GeneratorExit | CancelledError):
            raise
        raise BrokenPlugin(kind, name, package, error) from error


@lru_cache(maxsize=32)
def _added(kind: Kind, path: tuple[str, ...]) -> Mapping[str, Plugin]:
    """What packages on an import path add, by name, sorted; cached because the search takes 15 ms.

    Nobody replaces what ships. What several others add under one name is nowhere.
    """
    from importlib.metadata import entry_points  # a tenth of a second, which most commands need not wait for

    found = dict[str, Plugin]()
    for one in entry_points(group=GROUPS[kind]):
        package = f"{one.dist.name} {one.dist.version}" if one.dist else "another package"
        plugin, there = Plugin(kind, one.name, one.value, package), found.get(one.name)
        if there is None or plugin.ships:
            found[one.name] = plugin
        elif there.value != plugin.value and not there.ships:
            found[one.name] = replace(there, value="", package=f"{there.package} and {package}")
    return dict(sorted(found.items()))


def plugin_names(kind: Kind) -> tuple[str, ...]:
    """The names that packages of others add, sorted. Nothing is imported."""
    return tuple(name for name, one in _added(kind, tuple(sys.path)).items() if not one.ships)


def find_plugin(kind: Kind, spec: str) -> Plugin | None:
    """Find ``python:module:Name`` or an entry point by its spec, without an import; None if it does not exist."""
    name = spec_name(spec)
    if name.startswith(_DIRECT):
        return Plugin(kind, name, name.removeprefix(_DIRECT), spec=spec)
    plugin = _added(kind, tuple(sys.path)).get(name)
    return None if plugin is None else replace(plugin, spec=spec)


def robot_plugin(kind: Kind, name: str, what: str) -> Plugin:
    """What lockprobe-robot adds under a name, or a spec that begins with it, which is never that of another package.

    ``what`` needs it, with its verb, for the message: ``films need``.
    """
    plugin = find_plugin(kind, name)
    if plugin is None or not plugin.ships:
        raise Missing(f"{what} the package {ROBOT}", "pip install 'lockprobe[twin]'")
    return plugin


class Listed(NamedTuple):
    """A plug-in of an installed package in a list: what it says of itself; unused, without ``found``, why that is."""

    name: str
    package: str
    what: str
    found: Any = None


def listed_plugins(
    kind: Kind, own: Collection[str] = (), check: Callable[[str, Any], object] = lambda name, found: None
) -> list[Listed]:
    """All plug-ins of one kind, imported; unusable ones are included with the reason.

    No package can add Lockprobe's ``own`` names. ``check`` raises a user's mistake if an object cannot be used.
    """
    rows = []
    for name, plugin in _added(kind, tuple(sys.path)).items():
        if plugin.ships:
            continue
        try:
            if name in own:
                raise BadValue(kind, name, "a different name: Lockprobe itself uses this one")
            check(name, found := plugin.load())
            rows.append(Listed(name, plugin.package, first_line(found), found))
        except UserMistake as mistake:
            rows.append(Listed(name, plugin.package, f"Cannot be used. {mistake}"))
    return rows


def plugin_name_of(kind: Kind, found: type[Any]) -> str:
    """The name under which an installed package has a class; ``python:module:Name`` if none has it."""
    for one in _added(kind, tuple(sys.path)).values():
        if one.value.partition(":")[0].partition(".")[0] == found.__module__.partition(".")[0]:  # it may re-export it
            with suppress(UserMistake):
                if one.load() is found:
                    return one.name
    return f"{_DIRECT}{found.__module__}:{found.__qualname__}"


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
