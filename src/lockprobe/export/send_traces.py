"""Traces to a collector or viewer over OTLP/HTTP with JSON."""

from __future__ import annotations

import http.client
import json
import urllib.error
import urllib.request
from collections.abc import Iterable, Mapping
from urllib.parse import urlsplit

from lockprobe.errors import BadValue, Missing
from lockprobe.terminal_text import readable

__all__ = ["endpoint_of", "send_traces"]

_TIMEOUT = 30.0


def endpoint_of(url: str) -> str:
    """The URL to which traces are posted; a URL without a path gets OTLP's ``/v1/traces``.

    >>> endpoint_of("http://localhost:4318")
    'http://localhost:4318/v1/traces'

    Raises:
        BadValue: If it is no http or https URL.
    """
    try:
        parts = urlsplit(url)
        sound = parts.scheme in ("http", "https") and parts.hostname and (parts.port is None or parts.port)
    except ValueError:
        sound = False
    if not sound or not url.isascii() or not url.isprintable() or " " in url:
        raise BadValue("--endpoint", readable(url), "a URL such as http://localhost:4318/v1/traces")
    return parts._replace(path="/v1/traces").geturl() if parts.path in ("", "/") else url


def send_traces(requests: Iterable[Mapping[str, object]], url: str) -> int:
    """Post OTLP/JSON requests, one after the other, and return how many were accepted.

    Raises:
        BadValue: If the URL is none.
        Missing: If nobody answers there, or the receiver refuses a request.
    """
    endpoint, count = endpoint_of(url), 0
    for request in requests:
        body = json.dumps(request, ensure_ascii=False, allow_nan=False).encode()
        post = urllib.request.Request(  # noqa: S310 - the scheme is checked
            endpoint, body, {"Content-Type": "application/json"}, method="POST"
        )
        try:
            with urllib.request.urlopen(post, timeout=_TIMEOUT):  # noqa: S310 - the scheme is checked
                count += 1
        except (OSError, http.client.HTTPException) as error:
            raise Missing(f"{endpoint} took {count} requests and then failed ({_why(error)})", _remedy(error)) from None
    return count


def _why(error: Exception) -> str:
    if isinstance(error, urllib.error.HTTPError):
        return f"status {error.code}"
    reason = error.reason if isinstance(error, urllib.error.URLError) else error
    return readable(str(reason) or type(error).__name__).replace("\n", " ")


def _remedy(error: Exception) -> str:
    if isinstance(error, urllib.error.HTTPError) and error.code == 415:
        return "send to an OpenTelemetry Collector, which takes JSON and passes it on as protobuf"
    return "check the address, or write a file with --out FILE"
