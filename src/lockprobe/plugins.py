"""Plug-ins: additions of other packages by entry points, and classes that a user names as ``python:module:Name``.

A package adds an agent, a plant, a box, an intervention or a measure by an entry point in the group of that kind
(:data:`GROUPS`); the entry point's name is the spec's. ``python:module:Name?option=value`` names a class or a function
directly, on the command line and in Python, never in a file. Nothing is imported before it is used. An error in it
becomes one line that names the package.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache, reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from lockprobe.errors import BadFile, BadValue, BrokenPlugin, LockprobeError, UserMistake
from lockprobe.spec import arguments_from, spec_kind, split_specs

if TYPE_CHECKING:
    from importlib.metadata import EntryPoints

__all__ = [
    "GROUPS",
    "Kind",
    "Listed",
    "Plugin",
    "find_plugin",
    "listed_plugins",
    "plugin_name_of",
    "plugin_names",
    "refuse_python",
]

Kind = Literal["agent", "box", "intervention", "measure", "plant"]

GROUPS: Mapping[Kind, str] = {
    "agent": "lockprobe.agents",
    "box": "lockprobe.boxes",
    "intervention": "lockprobe.interventions",
    "measure": "lockprobe.measures",
    "plant": "lockprobe.plants",
}
"""Kind of addition -> the group of its entry points."""

_DIRECT = "python:"


@dataclass(frozen=True, slots=True, kw_only=True)
class Plugin:
    """A class, function or object of another package, not imported yet.

    Attributes:
        kind: The kind of addition, for example an agent.
        name: Its name in a spec: that of the entry point, or ``python:module:Name``.
        value: Where it is, ``module:Name``.
        package: The distribution with its version; empty for ``python:``.
    """

    kind: Kind
    name: str
    value: str
    package: str = ""

    def load(self) -> Any:
        """Import it.

        Raises:
            BadValue: If ``python:module:Name`` names nothing that can be imported.
            BrokenPlugin: If the package's module breaks, or does not have it.
        """
        module, _, path = self.value.partition(":")
        if not self.package and (here := str(Path.cwd())) not in sys.path:
            sys.path.insert(0, here)
        try:
            return reduce(getattr, path.split("."), importlib.import_module(module))
        except Exception as error:
            if self.package:
                raise BrokenPlugin(self.kind, self.name, self.package, error) from error
            expected = f"python:module:Name of an importable class or function ({_words(error)})"
            raise BadValue(self.kind, self.name, expected) from error

    def make(self, options: Mapping[str, str], **given: object) -> Any:
        """Call it with options as text, read by the annotation or the default of each argument, and with ``given``.

        An object that cannot be called is returned as it is.

        Raises:
            UnknownName: If it has no such option; the message lists those that exist.
            BadValue: If an option has an invalid value, or as :meth:`load`.
            BrokenPlugin: If it breaks.
        """
        found = self.load()
        if not callable(found):
            if options:
                raise BadValue(self.kind, self.name, f"no options: it is a {type(found).__name__}")
            return found
        with self.guarded():
            return found(**given, **arguments_from(found, self.name, options, given))

    @contextmanager
    def guarded(self) -> Iterator[None]:
        """Run code of the plug-in, and turn its errors into one line.

        Raises:
            BrokenPlugin: If it breaks. Lockprobe's own errors pass unchanged.
        """
        try:
            yield
        except LockprobeError:
            raise
        except Exception as error:
            raise BrokenPlugin(self.kind, self.name, self.package, error) from error


@dataclass(frozen=True, slots=True, kw_only=True)
class Listed:
    """A plug-in of an installed package, as an entry in a list.

    Attributes:
        name: Its name in a spec.
        package: The distribution with its version.
        what: The first line of its description, or the reason why it cannot be used.
        found: The imported object; None if it cannot be used.
    """

    name: str
    package: str
    what: str
    found: Any = None


def plugin_names(kind: Kind) -> tuple[str, ...]:
    """The names that installed packages add, sorted. Nothing is imported."""
    return tuple(sorted({point.name for point in _points(kind)}))


def find_plugin(kind: Kind, name: str) -> Plugin | None:
    """Find ``python:module:Name`` or an entry point by its name, without an import; None if it does not exist.

    Raises:
        BadValue: If several packages have it.
    """
    if name.startswith(_DIRECT):
        return Plugin(kind=kind, name=name, value=name.removeprefix(_DIRECT))
    points = [point for point in _points(kind) if point.name == name]
    if len({point.value for point in points}) > 1:
        raise BadValue(kind, name, f"a name from only one package, not from {' and '.join(map(_package, points))}")
    return Plugin(kind=kind, name=name, value=points[0].value, package=_package(points[0])) if points else None


def listed_plugins(
    kind: Kind, own: Collection[str] = (), check: Callable[[str, Any], object] = lambda name, found: None
) -> list[Listed]:
    """All plug-ins of one kind, imported; unusable ones are included with the reason.

    Args:
        kind: The kind.
        own: Lockprobe's own names; no package can add them.
        check: Called with the name and the imported object; raises a user's mistake if it cannot be used.
    """
    rows = []
    for name in plugin_names(kind):
        package = " and ".join(sorted({_package(point) for point in _points(kind) if point.name == name}))
        try:
            if name in own:
                raise BadValue(kind, name, "a different name: Lockprobe itself uses this one")
            plugin = find_plugin(kind, name)
            found = None if plugin is None else plugin.load()
            check(name, found)
        except UserMistake as mistake:
            rows.append(Listed(name=name, package=package, what=f"Cannot be used. {mistake}"))
            continue
        said = (getattr(found, "__doc__", None) or "").strip().partition("\n")[0]
        rows.append(Listed(name=name, package=package, what=said, found=found))
    return rows


def plugin_name_of(kind: Kind, found: type[Any]) -> str:
    """The name under which an installed package has a class; ``python:module:Name`` if none has it."""
    here = f"{found.__module__}:{found.__qualname__}"
    for point in _points(kind):
        if point.value == here:
            return str(point.name)
        if point.value.partition(":")[0].partition(".")[0] == found.__module__.partition(".")[0]:
            with suppress(UserMistake):
                if Plugin(kind=kind, name=point.name, value=point.value, package="?").load() is found:
                    return str(point.name)
    return f"{_DIRECT}{here}"


def refuse_python(path: Path, what: str, specs: Iterable[object]) -> None:
    """Refuse specs in a file that would run code, also within conditions.

    Raises:
        BadFile: If one begins with ``python:``.
    """
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


def _package(point: Any) -> str:
    return "another package" if point.dist is None else f"{point.dist.name} {point.dist.version}"


def _words(error: Exception) -> str:
    return str(error) if isinstance(error, ImportError | AttributeError) else f"{type(error).__name__}: {error}"
