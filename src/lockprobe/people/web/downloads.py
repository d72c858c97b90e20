"""Downloads for the experimenter, written by a background process and sent in pieces.

One file is written at a time. If a participant withdraws meanwhile, the file is written again without their data. The
file has no name on disk while it is sent.
"""

from __future__ import annotations

import asyncio
import gc
import os
import signal
from collections.abc import AsyncIterator, Callable, Hashable, Iterable
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, Protocol

from starlette.responses import Response, StreamingResponse

from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.interrupts import held_back
from lockprobe.people.web.refusals import RequestRefused

__all__ = ["Downloadable", "Downloads"]

PIECE = 1 << 18
"""Bytes of one piece."""

ATTEMPTS = 5
"""How often a file is rewritten because a participant withdraws, before the request is refused."""

BEHIND = 10
"""The nice value of the background process: participants come first."""

_MEDIA = {".csv": "text/csv; charset=utf-8", ".json": "application/json", ".zip": "application/zip"}


class Downloadable(Protocol):
    """One file to download.

    Attributes:
        name: The name of the file.
        about: Its content, in words.
        write: Writes it in another process; raises UserMistake if it cannot.
    """

    @property
    def name(self) -> str: ...  # noqa: D102 - above
    @property
    def about(self) -> str: ...  # noqa: D102
    @property
    def write(self) -> Callable[[Path], None]: ...  # noqa: D102


class Downloads:
    """The files to download. ``withdrawals`` returns a value that changes with every withdrawal."""

    def __init__(self, files: Iterable[Downloadable], withdrawals: Callable[[], Hashable]) -> None:
        self._files = {file.name: file for file in files}
        self._withdrawals = withdrawals
        self._writing = asyncio.Lock()

    @property
    def described(self) -> list[dict[str, str]]:
        """The name and content of each file."""
        return [{"name": file.name, "about": file.about} for file in self._files.values()]

    async def answer(self, name: str) -> Response:
        """The answer that holds a file.

        Raises:
            RequestRefused: As ``unknown`` if the file does not exist or cannot be written; as ``busy`` if people keep
                withdrawing.
        """
        if name not in self._files:
            raise RequestRefused("unknown", f"no such file; there are {', '.join(self._files) or 'none'}")
        async with self._writing:
            file = await self._written(self._files[name])
        size = os.fstat(file.fileno()).st_size
        headers = {"content-disposition": f'attachment; filename="{name}"', "content-length": str(size)}
        return StreamingResponse(_pieces(file), media_type=_MEDIA[Path(name).suffix], headers=headers)

    async def _written(self, wanted: Downloadable) -> IO[bytes]:
        for _ in range(ATTEMPTS):
            before = self._withdrawals()
            with TemporaryDirectory(prefix="lockprobe-") as place:
                file, mistake = Path(place) / "file", Path(place) / "mistake"
                await _elsewhere(wanted.write, file, mistake)
                if self._withdrawals() == before:
                    return _as_written(file, mistake)
        raise RequestRefused("busy", "people are withdrawing; try again")


async def _elsewhere(write: Callable[[Path], None], file: Path, mistake: Path) -> None:
    """Write a file in another process. If that fails, ``mistake`` holds the reason, or neither file exists."""
    process = get_context("spawn").Process(target=_write, args=(write, file, mistake), daemon=True)
    with held_back():
        process.start()
    try:
        await asyncio.to_thread(process.join)
    finally:
        process.kill()  # where nobody waits for it any more


def _as_written(file: Path, mistake: Path) -> IO[bytes]:
    if mistake.exists() or not file.exists():
        raise RequestRefused("unknown", mistake.read_text("utf-8") if mistake.exists() else "it could not be written")
    return file.open("rb")


def _write(write: Callable[[Path], None], file: Path, mistake: Path) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the server, which ends this
    os.nice(BEHIND)
    gc.disable()
    try:
        write(file)
    except UserMistake as refused:
        mistake.write_text(str(refused), "utf-8")


async def _pieces(file: IO[bytes]) -> AsyncIterator[bytes]:
    with file:
        while piece := await asyncio.to_thread(file.read, PIECE):
            yield piece
