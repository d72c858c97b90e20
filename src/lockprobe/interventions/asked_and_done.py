"""What is *asked*, *done* and *remembered*: warnings, instructions, remarks, another joint, and a past that is cut.

Reports stay as they are, and are true. Agents that read no words ignore what is asked.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from pathlib import Path
from string import Formatter
from typing import TYPE_CHECKING, Annotated, ClassVar

from lockprobe.agents.prompt import FIELDS
from lockprobe.foundation.errors import BadFile, BadValue, UnknownName
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.validation import Checked, Share, Within
from lockprobe.interventions.told import AtRandomSteps
from lockprobe.statistics.loops import onset
from lockprobe.trial.record import Ask, Briefing, Moment, Task, Turn

if TYPE_CHECKING:
    import numpy as np

ASIDES = (
    "Note: the room in which the panel stands has a window.",
    "Note: the table under the panel is as wide as the panel.",
    "Note: somebody has put a cup of coffee beside the panel.",
    "Note: the panel was built in a workshop on the ground floor.",
    "Note: the labels of the joints are printed in dark letters.",
    "Note: a calendar with pictures of boats hangs on the wall.",
)
"""The irrelevant sentences: they say nothing about the joints and do not change the meaning of the report."""

LARGEST_TEMPLATE = 16 * 1024
"""The most bytes of a template; the default instruction has about 800."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Warn(Checked):
    """The instruction warns that reports may be false, optionally with the rate; reports stay unchanged.

    Without a rate, [0, 1], it says "sometimes".
    """

    name: ClassVar[str] = "warn"
    rate: Share | None = None

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with the warning."""
        often = "sometimes" if self.rate is None else f"with probability {self.rate:g}"
        said = f"{briefing.warning} What you are told of your last action is {often} false."
        return replace(briefing, warning=said.lstrip())


@dataclass(frozen=True, slots=True, kw_only=True)
class Nudge(Checked):
    """A sentence tells the agent that it repeats itself, when it has just completed a copy of an action loop.

    A loop is a run of three or more choices, as in the paper (Sec. 3.3). With ``after=2`` it is the first loop of a
    trial, between whose copies there may be other choices, so it is said once at most; with more, it is said whenever
    the last choices are that many consecutive copies.
    """

    name: ClassVar[str] = "nudge"
    says: ClassVar[str] = "Note: you are repeating the same series of actions; consider trying another one."
    after: Annotated[int, Within(2)] = 2

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with the sentence, where it is due."""
        chosen, copies = tuple(moment.chosen for moment in past[1:]), self.after
        if copies == 2:
            due = len(chosen) > 0 and onset(chosen) == len(chosen)
        else:
            lengths = range(3, len(chosen) // copies + 1)
            due = any(chosen[-length:] * copies == chosen[-length * copies :] for length in lengths)
        return briefing.remarking(self.says) if due else briefing


@dataclass(frozen=True, slots=True, kw_only=True)
class Remark(Nudge):
    """The control of ``nudge``: at the same moments, a sentence of about that length without information."""

    name: ClassVar[str] = "remark"
    says: ClassVar[str] = "Note: this panel is made of wood, and its surface is painted in a light grey."


@dataclass(frozen=True, slots=True, kw_only=True)
class Distract(AtRandomSteps):
    """With probability p an irrelevant sentence comes with the report, which stays unchanged.

    Its moments are random, unlike those of ``remark``; the first step has none.
    """

    name: ClassVar[str] = "distract"

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with a sentence, or without."""
        said, which = rng.random(2)
        if len(past) < 2 or not self.hits(said, len(past) - 1):
            return briefing
        return briefing.remarking(ASIDES[int(which * len(ASIDES))])


@dataclass(frozen=True, slots=True, kw_only=True)
class Hypothesis(Checked):
    """Asks a hosted model for one sentence on how the box works, before or after it names a joint, or never.

    ``before`` is the default for every hosted model: a short chain of thought; ``--hypothesis`` sets another one for a
    whole study.
    """

    name: ClassVar[str] = "hypothesis"
    ask: Ask = "before"

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with when it is asked."""
        return replace(briefing, hypothesis=self.ask)


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnPrompt:
    """Gives a hosted model the instruction in a file instead of the default one; reports stay unchanged.

    The file is a template of at most :data:`LARGEST_TEMPLATE` bytes of UTF-8, with the fields ``{joints}``,
    ``{target}`` and ``{reply}``, and any others of :data:`lockprobe.agents.prompt.FIELDS`. It is read once, when this
    is made; its text and hash (the first sixteen digits of its SHA-256) stand in every record. Another content than
    that of a given hash is refused. A local model, which plays from a log, refuses it.
    """

    name: ClassVar[str] = "prompt"
    file: str = ""
    sha256: str = ""
    text: str = field(init=False, default="")

    def __post_init__(self) -> None:
        if not self.file:
            raise BadValue("file", self.file, "a file with an instruction: prompt?file=PATH")
        content = read_input(Path(self.file), LARGEST_TEMPLATE)
        found = hashlib.sha256(content).hexdigest()[:16]
        if self.sha256 not in ("", found):
            raise BadValue(f"sha256 of {self.file}", self.sha256, f"{found}, the hash of its present content")
        try:
            text = content.decode("utf-8").strip()
        except UnicodeDecodeError as error:
            raise BadFile(self.file, f"not UTF-8 ({error.reason})") from None
        try:
            names = [f"{name}{form or how or ''}" for _, name, form, how in Formatter().parse(text) if name is not None]
        except ValueError as error:
            said = "fields in single braces, and all other braces doubled"
            raise BadValue("template", str(error), said) from None
        for name in names:
            if name not in FIELDS:
                raise UnknownName("field of a template", name, FIELDS)
        if not {*FIELDS[:3]} <= {*names}:
            raise BadValue("fields of a template", ", ".join(names), f"at least {', '.join(FIELDS[:3])}")
        object.__setattr__(self, "sha256", found)
        object.__setattr__(self, "text", text)

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with the instruction."""
        return replace(briefing, instruction=self.text)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tremble(AtRandomSteps):
    """With probability p a random other joint is attempted instead of the chosen one, and reported truthfully."""

    name: ClassVar[str] = "tremble"

    def act(self, joint: str, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> str:
        """The joint, or another one."""
        slips, which = rng.random(2)
        others = [label for label in task.joints if label != joint]
        return others[int(which * len(others))] if self.hits(slips, len(past)) else joint


@dataclass(frozen=True, slots=True, kw_only=True)
class History(Checked):
    """The agent remembers only the ``last`` exchanges (choice and report); its task and the current report stay.

    Nothing is drawn.
    """

    name: ClassVar[str] = "history"
    last: Annotated[int, Within(0)] = 5

    def recall(
        self, turns: tuple[Turn, ...], past: tuple[Moment, ...], task: Task, rng: np.random.Generator
    ) -> tuple[Turn, ...]:
        """The newest exchanges."""
        return turns[len(turns) - self.last :] if self.last < len(turns) else turns
