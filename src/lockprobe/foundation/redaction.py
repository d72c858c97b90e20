"""Redaction of secrets: keys from the environment, and any text that looks like a key."""

from __future__ import annotations

import base64
import json
import os
import re
from functools import lru_cache
from urllib.parse import parse_qsl, quote, unquote, urlsplit

_SECRET_NAME = re.compile(
    r"(KEY|KEY_ID|TOKEN|SECRET|PASSWORD|PASSWD|CREDENTIALS|HEADERS|SIG|SIGNATURE|(ORG|PROJECT|ACCOUNT)_ID)$"
)
_SHORTEST_SECRET = 6

_Environment = tuple[tuple[bytes | str, bytes | str], ...]
"""Variables and their values."""

_SHAPES = (
    (re.compile(r"\b(?:(?:sk|pk|hf|gsk|xai|ghp)[-_]|AIza|AKIA)[A-Za-z0-9_\-*.]{6,}"), "[secret]"),
    (re.compile(r"(?i)(?<=bearer )(?!token)[^\s\"',;}]+"), "[secret]"),
    (re.compile(r"(?<=://)[^/\s\"'@]+(?=@)"), "[secret]"),
    (re.compile(r"(https?://[^\s\"'?]+)\?[^\s\"']+"), r"\1?[secret]"),
    (
        re.compile(
            r"(?i)((?:authorization|cookie|api[-_]?key|(?:access|auth|session)[-_]token|openai-organization)"
            r"[\"']?\s*[:=]\s*[\"']?)(?:(?:bearer|basic)\s+)?[^\s\"',;}&]+"
        ),
        r"\1[secret]",
    ),
)
"""Patterns of secrets: keys by their prefix, user and query in a URL, header lines."""


def without_keys(text: str) -> str:
    """The text, encodable as UTF-8, with every secret of the environment removed.

    Secrets are found in plain form, encoded for a URL or in Base64, and with any of their characters as JSON escapes.
    """
    text = text.encode("utf-8", "replace").decode("utf-8")
    # as Python holds them: to decode them all takes longer than all else here
    environment: _Environment = tuple(getattr(os.environ, "_data", os.environ).items())
    for secret in _secrets_of(environment):
        text = text.replace(secret, "[secret]")
    if "\\" in text:
        for spelling in _escaped_secrets_of(environment):
            text = spelling.sub("[secret]", text)
    return text


def without_secrets(text: str) -> str:
    """The text without secrets of the environment and without anything that looks like a secret."""
    text = without_keys(text)
    for shape, instead in _SHAPES:
        text = shape.sub(instead, text)
    return text


@lru_cache(maxsize=4)
def _secrets_of(environment: _Environment) -> tuple[str, ...]:
    """The secrets in an environment in all their encodings, longest first."""
    found: set[str] = set()
    for name, value in ((os.fsdecode(name), os.fsdecode(value)) for name, value in environment):
        if _SECRET_NAME.search(name.upper()):
            lines = [line.partition(":")[2] for line in value.splitlines()] if name.upper().endswith("HEADERS") else []
            found |= {value, *lines, *(line.split()[-1] for line in lines if line.split())}
        if "://" in value:
            found |= _secrets_in_url(value)
    plain = {secret.strip() for secret in found} | {unquote(secret.strip()) for secret in found}
    written = {form for secret in plain for form in (secret, quote(secret, safe=""), json.dumps(secret)[1:-1])}
    encoded = {base64.b64encode(secret.encode("utf-8", "replace")).decode("ascii") for secret in plain}
    usable = (form for form in written | encoded if len(form) >= _SHORTEST_SECRET)
    return tuple(sorted(usable, key=lambda form: (-len(form), form)))


@lru_cache(maxsize=4)
def _escaped_secrets_of(environment: _Environment) -> tuple[re.Pattern[str], ...]:
    """The secrets as patterns in which any character may be escaped as in JSON, once or repeatedly."""
    return tuple(re.compile("".join(map(_escaped, secret))) for secret in _secrets_of(environment))


def _escaped(character: str) -> str:
    code = character.encode("utf-16-be").hex()
    units = "".join(rf"\\+u(?i:{code[i : i + 4]})" for i in range(0, len(code), 4))
    plain = re.escape(character) if character.isalnum() else rf"\\*{re.escape(character)}"
    return f"(?:{plain}|{units})"


def _secrets_in_url(url: str) -> set[str]:
    try:
        parts = urlsplit(url)
        values = {value for name, value in parse_qsl(parts.query) if _SECRET_NAME.search(name.upper())}
    except ValueError:
        return set()
    return values | ({parts.password, f"{parts.username}:{parts.password}"} if parts.password else set())
