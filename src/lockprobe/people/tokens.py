"""Tokens by which a browser proves that it is the same as before, and what else hangs on the secret of a study."""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
from pathlib import Path

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage.atomic_file import write_private
from lockprobe.people.scenes import ActRefused

TOKENS = "secret"
"""The file of the secret, in the directory of people."""

_BYTES = 32


class Tokens:
    """Issues and recognises tokens: a random number and its keyed hash (HMAC) under the secret of this study.

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
        chance = secrets.token_hex(_BYTES)
        return chance + self._sealed(chance)

    def mark(self, token: str) -> str:
        """SHA-256 of a token, under which it is stored. The token cannot be derived from it.

        Raises:
            ActRefused: As ``forged``, if the token was not issued here.
        """
        chance = token[: 2 * _BYTES]
        if not re.fullmatch("[0-9a-f]+", token) or not hmac.compare_digest(token, chance + self._sealed(chance)):
            raise ActRefused("forged", "a token that was not given out here")
        return hashlib.sha256(token.encode()).hexdigest()

    @property
    def preview(self) -> str:
        """The key with which an experimenter looks at the study."""
        return self._sealed("preview")[:16]

    def digest(self, person: str) -> str:
        """A keyed digest of a person's ID on a recruitment platform, which tells nobody the ID."""
        return self._sealed(f"withdrew {person}")

    def _sealed(self, text: str) -> str:
        return hmac.digest(self._secret, text.encode(), "sha256").hex()
