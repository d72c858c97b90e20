"""Shards: parts of a study's trials, which several machines can play without communication."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from typing import Self

from lockprobe.foundation.errors import BadValue


@dataclass(frozen=True, slots=True, kw_only=True)
class Shard:
    """One shard of a study, ``number`` (from 1) of ``of``. A hash of its key assigns every trial to exactly one.

    A shard is not a setting of the study: ``lockprobe import`` merges the directories of all shards.
    """

    number: int
    of: int

    def __post_init__(self) -> None:
        if not 1 <= self.number <= self.of <= 100_000:
            raise BadValue("shard", str(self), "i/n with i from 1 to n, and n of at most 100000")

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"

    @classmethod
    def parse(cls, text: str) -> Self:
        """The shard of a text such as ``3/16``."""
        found = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", text)
        if found is None:
            raise BadValue("shard", text, "i/n, for example 3/16 for the third of 16 parts")
        return cls(number=int(found[1]), of=int(found[2]))

    def has(self, key: str) -> bool:
        """Whether the trial with this key is in the shard."""
        return int.from_bytes(hashlib.sha256(key.encode()).digest()[:8]) % self.of == self.number - 1
