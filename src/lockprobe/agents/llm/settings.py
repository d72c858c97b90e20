"""What can be set of a hosted model: the options in its spec, ``llm:openai/gpt-4o?temperature=0&images=4``."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Literal

from lockprobe.agents.llm.knowledge import ModelFacts, facts_of
from lockprobe.errors import BadValue
from lockprobe.options import read_options, with_options
from lockprobe.record import Fact

__all__ = ["Settings", "read_settings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How a model is asked.

    Attributes:
        images: How many observations, the newest, keep their pictures in the conversation; 0 for all.
        detail: How closely the provider is asked to look, where it offers that.
        repairs: How often a malformed reply is asked for again before the trial ends as ``error``.

    Raises:
        BadValue: If a number is out of range.
    """

    images: int = 0
    detail: Literal["auto", "low", "high"] = "high"
    repairs: int = 4

    def __post_init__(self) -> None:
        if self.images < 0:
            raise BadValue("images", self.images, "how many observations keep their pictures, 0 for all")
        if not 0 <= self.repairs <= 20:
            raise BadValue("repairs", self.repairs, "a whole number from 0 to 20")

    def sent(self, facts: ModelFacts) -> dict[str, Fact]:
        """What is sent with every request besides the conversation, and what is left to the provider, for the record.

        Args:
            facts: What is known of the model.
        """
        changed = {f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name) != f.default}
        return {"temperature": "provider default", **asdict(self), **changed} if changed else {"repairs": self.repairs}


def read_settings(spec: str) -> tuple[str, Settings]:
    """The model's name and how it is asked, from its spec without ``llm:``.

    Raises:
        UnknownName: If there is no such option.
        BadValue: If an option has a value that it cannot have, or one that this model is known to refuse.
    """
    name, options = read_options(spec)
    settings = with_options(Settings, f"llm:{name}", options)
    facts_of(name)
    return name, settings
