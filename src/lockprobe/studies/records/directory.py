"""The directory of a study: its lock and its settings file. A failed start leaves it unchanged.

Agents can be added to a study that has been played, and it can be extended; no other setting can change after the first
trial.
"""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Self

from lockprobe.foundation.errors import BadFile, DirectoryBusy, SettingsChanged
from lockprobe.foundation.inputs import parse_json, read_input
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.foundation.storage.links import refuse_links
from lockprobe.studies.file_names import PEOPLE_DIRECTORY, SETTINGS
from lockprobe.studies.options.agent_names import joined_agents
from lockprobe.studies.options.settings_hash import in_no_order
from lockprobe.studies.records.store import STORE, has_joined, holds_records
from lockprobe.studies.study import Study
from lockprobe.studies.until import Until
from lockprobe.trial.condition import TRUTH
from lockprobe.trial.record import STATES

_SIZE = ("repetitions", "trials", "strategy_trials", "until")
"""The settings that say how much is played."""

_BESIDE = frozenset({"agents", "names", "contrasts", "extended", "shard"})
"""What stands beside the settings that a study on disk must have in common with the one that is asked for."""

_MADE = (SETTINGS, STORE)
"""Files that a start creates."""


_LOCK = ".lock"
"""The file that is locked where directories are not."""


class StudyDirectory:
    """A study directory locked for writing by this process; created if missing.

    The lock is on the directory itself, so it is independent of the files. If an error occurs before anything was
    played, asked or joined, new files and directories are removed and the settings are restored.

    Attributes:
        used: Whether something was played or asked; set it to True, and an error removes nothing.

    Raises:
        BadFile: On entering, if it cannot be made, or a link inside it leads elsewhere.
        DirectoryBusy: On entering, if another process writes there.
    """

    def __init__(self, path: Path) -> None:
        self.used = False
        self._path = path
        self._new = [one for one in (path, *path.parents) if not one.exists()]

    def __enter__(self) -> Self:
        refuse_links(self._path)
        for name in (*_MADE, PEOPLE_DIRECTORY):  # it may have no settings yet by which it is known
            refuse_links(self._path / name, within=self._path)
        try:
            self._path.mkdir(parents=True, exist_ok=True)
            self._handle = os.open(self._path, os.O_RDONLY)
        except OSError as error:
            self._remove_new()
            raise BadFile(self._path, f"cannot be written ({error.strerror})") from error
        self._locked = [self._handle]
        try:
            self._lock()
        except BlockingIOError:
            self._close()
            raise DirectoryBusy(self._path) from None
        except OSError:  # a file system without locks
            pass
        self._there = {name for name in (*_MADE, PEOPLE_DIRECTORY) if (self._path / name).exists()}
        settings = self._path / SETTINGS
        self._settings = settings.read_bytes() if settings.is_file() else None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            failed = kind is not None and not issubclass(kind, KeyboardInterrupt | DirectoryBusy)
            if failed and not self.used:
                self._undo()
        finally:
            self._close()

    def _lock(self) -> None:
        """Lock the directory against other writers, or a file in it where the file system locks no directories."""
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise
        except OSError:
            file = os.open(self._path / _LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)
            self._locked.append(file)
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _close(self) -> None:
        for handle in self._locked:
            os.close(handle)

    def _undo(self) -> None:
        """Restore the directory, unless it was replaced or people were invited."""
        with suppress(OSError, BadFile):
            invited = PEOPLE_DIRECTORY not in self._there and (self._path / PEOPLE_DIRECTORY).exists()
            if invited or not os.path.samestat(os.fstat(self._handle), self._path.stat()):
                return
            for name in (*_MADE, _LOCK):
                if name not in self._there:
                    (self._path / name).unlink(missing_ok=True)
            settings = self._path / SETTINGS
            if self._settings is not None and settings.read_bytes() != self._settings:
                write_file(settings, self._settings, alone=True)
            self._remove_new()

    def _remove_new(self) -> None:
        for path in self._new:
            with suppress(OSError):
                path.rmdir()


def read_settings(directory: Path | str) -> dict[str, object]:
    """The settings of the study in a directory.

    Raises:
        BadFile: If the file is missing, or holds no settings of a study.
    """
    path = Path(directory) / SETTINGS
    if not path.exists():
        raise BadFile(directory, f"no {SETTINGS} here; is it the directory of a study?")
    settings = parse_json(read_input(path), path)
    if not isinstance(settings, dict) or not _are_of_a_study(settings):
        raise BadFile(path, "not the settings of a study")
    return settings


def _are_of_a_study(settings: Mapping[str, object]) -> bool:
    match settings:
        case {"agents": list(), "conditions": list(), "repetitions": int(), "trials": int()}:
            return True
        case _:
            return False


def write_settings(directory: Path, study: Study) -> None:
    """Write the settings of a study atomically.

    What they say of earlier sizes is never forgotten, nor are contrasts, unless the study has others.

    Raises:
        BadFile: If they cannot be written.
    """
    earlier: object = [size._asdict() for size in study.earlier]
    contrasts: object = study.contrast_settings
    if holds_records(directory) and (directory / SETTINGS).exists():
        there = read_settings(directory)
        earlier = there["extended"] if _plans(there) > len(study.earlier) else earlier
        contrasts = contrasts or there.get("contrasts")
    settings = {
        **study.settings(),
        **({"contrasts": contrasts} if contrasts else {}),
        **({"extended": earlier} if earlier else {}),
        **({"shard": str(study.shard)} if study.shard else {}),
    }
    write_file(directory / SETTINGS, f"{json.dumps(settings, indent=2)}\n", alone=True)


def claim(directory: Path, study: Study) -> None:
    """Write the settings of a new study, or check them against the settings on disk. New agents are added.

    A study that was extended (:func:`lockprobe.studies.extension.extended`) may have another size than there.

    Raises:
        SettingsChanged: If any other setting differs.
        BadFile: If there are records without settings, or settings that cannot be read or written.
    """
    path, played = directory / SETTINGS, holds_records(directory)
    if not path.exists() and played:
        raise BadFile(directory, f"holds {STORE} but no {SETTINGS}: put it back, or give another --out")
    somebody = path.exists() and has_joined(directory)  # who has joined plays this study
    if not (played or somebody):
        write_settings(directory, study)
        return
    there = read_settings(directory)
    extended = _plans(there) < len(study.earlier)
    asked = json.loads(json.dumps(study.settings()))
    known, wanted = in_no_order(there), in_no_order(asked)
    different = {
        name: told_apart(name, there.get(name), asked.get(name))
        for name in sorted({*known, *wanted} - _BESIDE - {*(_SIZE if extended else ())})
        if known.get(name) != wanted.get(name)
    } | _renamed(there, study)
    if different:
        raise SettingsChanged(directory, different)
    agents = joined_agents(_texts(there["agents"]), study.agents)
    part = study.shard if str(study.shard) == there.get("shard") else None  # of several parts it holds the whole
    asks = bool(study.contrasts) and study.contrast_settings != there.get("contrasts")
    if extended or asks or list(agents) != there["agents"] or str(part) != str(there.get("shard")):
        joined = replace(study, agents=agents, names={**_names(there), **study.names}, shard=part)
        write_settings(directory, joined.ordered_as(there))


def _plans(settings: Mapping[str, object]) -> int:
    """How often a study was extended."""
    found = settings.get("extended")
    return len(found) if isinstance(found, list) else 0


def _names(settings: Mapping[str, object]) -> dict[str, str]:
    """Spec -> name of the agents that have one."""
    names = settings.get("names")
    return {str(spec): str(name) for spec, name in names.items()} if isinstance(names, dict) else {}


def _renamed(there: Mapping[str, object], study: Study) -> dict[str, tuple[object, object]]:
    """The agents that are called otherwise in a directory."""
    names = _names(there)
    return {
        f"name of {agent}": (names.get(agent, agent), study.label_of(agent))
        for agent in _texts(there["agents"])
        if agent in study.agents and names.get(agent, agent) != study.label_of(agent)
    }


def told_apart(name: str, there: object, asked: object) -> tuple[object, object]:
    """Two values of a setting for a message: boxes by name, or by the parts that differ if their names are equal."""
    if name == "conditions":
        return _conditions_said(there), _conditions_said(asked)
    if name == "until":
        return _until_said(there), _until_said(asked)
    if name == "more_boxes":
        return _boxes_said(there), _boxes_said(asked)
    if not (isinstance(there, dict) and isinstance(asked, dict)):
        return there, asked
    parts = [name for name in ("name", *there, *asked) if there.get(name) != asked.get(name)]
    first = parts[0] if parts else "name"
    if first == "name":
        return there.get("name"), asked.get("name")
    return {first: there.get(first)}, {first: asked.get(first)}


def _boxes_said(boxes: object) -> str:
    """The names of further boxes."""
    return ", ".join(str(box.get("name")) for box in boxes) if isinstance(boxes, list) else "none"


def _until_said(until: object) -> str:
    """When a study stops, as it is given on the command line."""
    if not isinstance(until, dict):
        return "never"
    return str(Until(**until)) if {*until} == {"rule", "points"} else str(until)


def _conditions_said(conditions: object) -> str:
    """Conditions by name or, without names, by their interventions."""
    if not isinstance(conditions, list):
        return "none"
    return "; ".join(_condition_said(one) if isinstance(one, dict) else str(one) for one in conditions)


def _condition_said(condition: Mapping[str, object]) -> str:
    acting = condition.get("interventions")
    specs = [str(one.get("spec")) for one in acting if isinstance(one, dict)] if isinstance(acting, list) else []
    shown = str(condition.get("modality", STATES))
    said = specs if shown == STATES else [*specs, shown]
    acts, name = " + ".join(said) or TRUTH, str(condition.get("name", ""))
    return f"{name}={acts}" if name else acts


def _texts(values: object) -> list[str]:
    return [str(value) for value in values] if isinstance(values, Iterable) else []
