"""The pictures of a trial in an Inspect sample.

Measured depth is not shown, and a picture that was scaled down for a model differs from the recorded one.
"""

from __future__ import annotations

import base64
import binascii
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from lockprobe.foundation.errors import needing
from lockprobe.foundation.inputs import read_input
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Trial

with needing("Inspect logs", "providers"):
    from inspect_ai.model import ChatMessage, ContentImage

__all__ = ["PICTURES", "beside", "pictures_of"]

PICTURES = "pictures"
"""The key in the store of a sample for pictures that no message shows: name -> data URI."""

_URI = "data:image/png;base64,"


def beside(trial: Trial, messages: Iterable[ChatMessage], directory: Path) -> dict[str, dict[str, str]]:
    """The pictures for the store of a sample: recorded pictures in the directory that are in no message."""
    unseen = trial.picture_names - {name for name, _ in pictures_of(messages, {})}
    files = [file for name in sorted(unseen) if (file := directory / name).is_file()]
    uris = {file.name: _URI + base64.b64encode(read_input(file)).decode("ascii") for file in files}
    return {PICTURES: uris} if uris else {}


def pictures_of(messages: Iterable[ChatMessage], store: Mapping[str, object]) -> Iterator[tuple[str, bytes]]:
    """Every picture in the messages and in the store of a sample, with its name."""
    kept = store.get(PICTURES)
    uris = [uri for uri in kept.values() if isinstance(uri, str)] if isinstance(kept, dict) else []
    for message in messages:
        parts = [] if isinstance(message.content, str) else message.content
        uris += [part.image for part in parts if isinstance(part, ContentImage)]
    for uri in uris:
        if uri.startswith(_URI):
            try:
                png = base64.b64decode(uri.removeprefix(_URI), validate=True)
            except binascii.Error:
                continue
            yield Picture(kind="rgb", png=png).name, png
