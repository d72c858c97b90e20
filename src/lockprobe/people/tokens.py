"""By what a browser proves that it is the same as before. A token that was not given out here is found out."""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
import os
import secrets
from pathlib import Path

from lockprobe.errors import BadFile
from lockprobe.people.refusals import Refused

__all__ = ["Tokens", "mark_of"]

_BYTES = 32
_LENGTH = len(base64.urlsafe_b64encode(bytes(2 * _BYTES)))


class Tokens:
    """Gives tokens out and knows its own: random bytes, and what only this study can make of them.

    Args:
        path: Of the secret, made where there is none; nobody else can read it.

    Raises:
        BadFile: If it cannot be read or made, or is none.
    """

    def __init__(self, path: Path) -> None:
        try:
            if not path.exists():
                _make(path)
            self._secret = path.read_bytes()
        except OSError as error:
            raise BadFile(path, f"cannot be used ({error.strerror})") from error
        if len(self._secret) != _BYTES:
            raise BadFile(path, f"is no secret of {_BYTES} bytes; without it nobody can go on where they were")

    def new(self) -> str:
        """A token for somebody who has none."""
        chance = secrets.token_bytes(_BYTES)
        return base64.urlsafe_b64encode(chance + self._sealed(chance)).decode("ascii")

    def mark(self, token: str) -> str:
        """By what a token is known here: its SHA-256, from which it cannot be made.

        Raises:
            Refused: As ``forged``, if it was not given out here.
        """
        try:
            raw = base64.b64decode(token.encode("ascii"), altchars=b"-_", validate=True)
        except (UnicodeEncodeError, binascii.Error, ValueError):
            raw = b""
        right = len(token) == _LENGTH and len(raw) == 2 * _BYTES
        if not right or not hmac.compare_digest(raw[_BYTES:], self._sealed(raw[:_BYTES])):
            raise Refused("forged", "a token that was not given out here")
        return mark_of(token)

    def _sealed(self, chance: bytes) -> bytes:
        return hmac.digest(self._secret, chance, "sha256")


def mark_of(token: str) -> str:
    """SHA-256 of a token."""
    return hashlib.sha256(token.encode("ascii")).hexdigest()


def _make(path: Path) -> None:
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    draft = path.with_suffix(".draft")
    draft.unlink(missing_ok=True)
    handle = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    try:
        os.write(handle, secrets.token_bytes(_BYTES))
        os.fsync(handle)
    finally:
        os.close(handle)
    draft.replace(path)
