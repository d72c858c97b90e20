"""The intervention ``prompt``: an instruction from a file."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from lockprobe.agents.prompt import check_template
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.inputs import read_input
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.record import Moment, Task

LARGEST_TEMPLATE = 16 * 1024
"""The most bytes of a template; the default instruction has about 800."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnPrompt:
    """Gives a hosted model the instruction in a file instead of the default one; reports stay unchanged.

    The file is a template with the fields ``{joints}``, ``{target}`` and ``{reply}``, and any of ``{budget}``,
    ``{count}``, ``{names}`` and ``{observation}`` (:data:`lockprobe.agents.prompt.FIELDS`). It is read once, when this
    is made; its text and hash stand in every record. Strategies ignore it; a local model, which plays from a
    log, refuses it. Nothing is drawn.

    Attributes:
        file: The file, at most :data:`LARGEST_TEMPLATE` bytes of UTF-8.
        sha256: The first sixteen hexadecimal digits of its SHA-256; where they are given, another content is refused.
        text: The template.

    Raises:
        BadFile: If the file cannot be read, is too large, or is not UTF-8.
        UnknownName: If the template has a field that does not exist; the message lists those that do.
        BadValue: If it lacks a required field, or its content does not match ``sha256``.
    """

    name: ClassVar[str] = "prompt"
    file: str = ""
    sha256: str = ""
    text: str = field(init=False, default="")

    def __post_init__(self) -> None:
        if not self.file:
            raise BadValue("file", self.file, "a file with an instruction: prompt?file=PATH")
        path = Path(self.file)
        content = read_input(path, LARGEST_TEMPLATE)
        found = hashlib.sha256(content).hexdigest()[:16]
        if self.sha256 not in ("", found):
            raise BadValue(f"sha256 of {self.file}", self.sha256, f"{found}, the hash of its present content")
        try:
            text = content.decode("utf-8").strip()
        except UnicodeDecodeError as error:
            raise BadFile(path, f"not UTF-8 ({error.reason})") from None
        check_template(text)
        object.__setattr__(self, "sha256", found)
        object.__setattr__(self, "text", text)

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with the instruction."""
        return replace(briefing, instruction=self.text)
