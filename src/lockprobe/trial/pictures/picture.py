"""A picture as a PNG file, named by its hash."""

from __future__ import annotations

import hashlib
import re
from base64 import b64encode
from dataclasses import dataclass, field
from typing import Annotated, Literal

from pydantic import Field

PictureKind = Literal["rgb", "depth", "depth16"]
"""Colours; depth as the agent sees it; measured depth in millimetres."""

PICTURE_NAME = re.compile(r"[0-9a-f]{20}\.png")
"""The file names of pictures: no record points outside its directory."""

PictureName = Annotated[str, Field(pattern=f"^{PICTURE_NAME.pattern}$")]
"""One of them, read from a record."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """One picture in a percept.

    Attributes:
        kind: What it shows.
        png: The bytes of the file.
        shown: Whether the agent sees it; otherwise it is only recorded.
    """

    kind: PictureKind
    png: bytes = field(repr=False)
    shown: bool = True

    @property
    def name(self) -> str:
        """Its file name, a hash of its bytes: equal names mean equal pictures."""
        return f"{hashlib.sha256(self.png).hexdigest()[:20]}.png"

    @property
    def base64(self) -> str:
        """The bytes of the file as a text, as messages carry them."""
        return b64encode(self.png).decode("ascii")
