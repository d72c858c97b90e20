"""The static files of the page, read once and looked up by name: no request becomes a path."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from starlette.requests import Request
from starlette.responses import Response

from lockprobe.foundation.errors import BadFile
from lockprobe.people.web.refusals import RequestRefused

STATIC = Path(__file__).with_name("static")

KINDS = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".json": "application/json",
    ".txt": "text/plain; charset=utf-8",
    ".svg": "image/svg+xml",
}
"""The content types of served files, by ending."""

_AGAIN = "no-cache"  # kept, and asked for again: a new release is seen at once


@dataclass(frozen=True, slots=True)
class File:
    """The content of a file, its type, and a tag that changes with the content."""

    content: bytes
    kind: str
    tag: str


class Files:
    """The files in a directory, not below it.

    Raises:
        BadFile: If one cannot be read.
    """

    def __init__(self, directory: Path = STATIC) -> None:
        try:
            self._files: Mapping[str, File] = {
                path.name: _read(path) for path in sorted(directory.iterdir()) if path.suffix in KINDS
            }
        except OSError as error:
            raise BadFile(error.filename or directory, f"cannot be read ({error.strerror})") from error

    def answer(self, name: str, request: Request) -> Response:
        """The file, or 304 if the browser has it.

        Raises:
            RequestRefused: If there is none.
        """
        file = self._files.get(name)
        if file is None:
            raise RequestRefused("unknown", "there is nothing here")
        headers = {"etag": file.tag, "cache-control": _AGAIN, "content-type": file.kind}
        known = {tag.strip().removeprefix("W/") for tag in request.headers.get("if-none-match", "").split(",")}
        if file.tag in known:
            return Response(status_code=304, headers=headers)
        return Response(file.content, headers=headers)


def page_version(directory: Path = STATIC) -> str:
    """The version of the participants' page, for the record.

    Raises:
        BadFile: If the page was not built.
    """
    path = directory / "page.json"
    try:
        return str(json.loads(path.read_bytes())["version"])
    except (OSError, ValueError, KeyError, TypeError):
        raise BadFile(path, "names no version of the page; was it built?") from None


def _read(path: Path) -> File:
    content = path.read_bytes()
    return File(content, KINDS[path.suffix], f'"{hashlib.sha256(content).hexdigest()[:24]}"')
