"""Tokens by which a browser proves that it is the same as before. A forged token is detected."""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
import secrets
from pathlib import Path

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage.atomic_file import write_private
from lockprobe.people.refusals import ActRefused

TOKENS = "secret"
"""The file of the secret, next to the diaries."""

_BYTES = 32


class Tokens:
    """Issues and recognises tokens: random bytes and their keyed hash (HMAC) under the secret of this study.

    Args:
        path: The file of the secret. It is created if missing; only its owner can read it.
        given: Whether tokens were issued before, so that the file has to exist.

    Raises:
        BadFile: If it cannot be read or made, or holds no such secret.
    """

    def __init__(self, path: Path, *, given: bool = False) -> None:
        if path.is_symlink() or (path.exists() and not path.is_file()) or (given and not path.exists()):
            raise BadFile(
                path,
                "missing, or not a regular file: without it no participant can resume. Restore it; if it is lost, "
                f"a file of {_BYTES} random bytes lets new people join",
            )
        try:
            if not path.exists():
                write_private(path, secrets.token_bytes(_BYTES), mode=0o600)
            path.chmod(0o600)
            self._secret = path.read_bytes()
        except OSError as error:
            raise BadFile(path, f"cannot be used ({error.strerror})") from error
        if len(self._secret) != _BYTES:
            raise BadFile(path, f"not a secret of {_BYTES} bytes; without it no participant can resume")

    def new(self) -> str:
        """A new token."""
        chance = secrets.token_bytes(_BYTES)
        return _written(chance + self._sealed(chance))

    def mark(self, token: str) -> str:
        """SHA-256 of a token, under which it is stored. The token cannot be derived from it.

        Raises:
            ActRefused: As ``forged``, if the token was not issued here.
        """
        try:
            raw = base64.b64decode(token.encode("ascii"), altchars=b"-_", validate=True)
        except (UnicodeEncodeError, binascii.Error, ValueError):
            raw = b""
        right = len(raw) == 2 * _BYTES and _written(raw) == token  # one way only: bits that fill it up are none of it
        if not right or not hmac.compare_digest(raw[_BYTES:], self._sealed(raw[:_BYTES])):
            raise ActRefused("forged", "a token that was not given out here")
        return hashlib.sha256(token.encode()).hexdigest()

    @property
    def preview(self) -> str:
        """The key with which an experimenter looks at the study."""
        return hmac.digest(self._secret, b"preview", "sha256").hex()[:16]

    def digest(self, person: str) -> str:
        """A keyed digest of a person's ID on a recruitment platform, which tells nobody the ID."""
        return hmac.digest(self._secret, b"withdrew " + person.encode(), "sha256").hex()

    def _sealed(self, chance: bytes) -> bytes:
        return hmac.digest(self._secret, chance, "sha256")


def _written(raw: bytes) -> str:
    return base64.urlsafe_b64encode(raw).decode("ascii")
