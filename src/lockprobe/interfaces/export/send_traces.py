"""Sends traces to a collector or viewer over OTLP/HTTP: as protobuf if its package is installed, else as JSON."""

from __future__ import annotations

import base64
import http.client
import json
import os
import re
import urllib.error
import urllib.request
from collections.abc import Iterable, Mapping
from typing import Any
from urllib.parse import unquote, urlsplit

from lockprobe.foundation.errors import BadValue, Missing
from lockprobe.foundation.terminal_text import readable

__all__ = ["endpoints_of", "send_traces"]

_TIMEOUT = 30.0
_LARGEST_ANSWER = 1 << 16
_PATH = "/v1/traces"

_NOT_HERE = (301, 302, 307, 308, 400, 401, 403, 404, 405, 410, 501)
"""Statuses of a server that takes no traces at this path."""

_HEADERS = "OTEL_EXPORTER_OTLP_HEADERS"
_NAME = re.compile(r"[A-Za-z0-9!#$%&'*+.^_`|~-]+")
_IDS = ("traceId", "spanId", "parentSpanId")


def endpoints_of(url: str) -> tuple[str, ...]:
    """The URLs to which traces may be posted: as given, then with OTLP's ``/v1/traces`` after it.

    >>> endpoints_of("http://localhost:4318")
    ('http://localhost:4318/v1/traces',)
    >>> endpoints_of("http://localhost:3000/otel/")
    ('http://localhost:3000/otel/', 'http://localhost:3000/otel/v1/traces')
    >>> endpoints_of("http://localhost:4318/v1")[1]
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
    path = parts.path.rstrip("/")
    if path.endswith(_PATH):
        return (url,)
    whole = parts._replace(path=path.removesuffix("/v1") + _PATH).geturl()
    return (url, whole) if path else (whole,)


def send_traces(requests: Iterable[Mapping[str, object]], url: str) -> int:
    """Post OTLP/JSON requests, one after the other, and return how many were accepted.

    ``OTEL_EXPORTER_OTLP_HEADERS`` in the environment holds further headers, such as a key, as OpenTelemetry's exporters
    read them: ``NAME=VALUE,NAME=VALUE`` with values as in a URL.

    Raises:
        BadValue: If the URL or the headers are invalid.
        Missing: If the receiver does not answer, or refuses a request.
    """
    endpoints, headers, count = list(endpoints_of(url)), _headers(), 0
    tried = list[str]()
    for request in requests:
        body, kind = _encoded(request)
        sent = {**headers, "Content-Type": kind}
        while True:
            try:
                _post(endpoints[0], body, sent)
            except (OSError, http.client.HTTPException) as error:
                if isinstance(error, urllib.error.HTTPError):
                    error.close()
                tried.append(endpoints.pop(0))
                if not (endpoints and not count and _is_elsewhere(error)):
                    said = f"{' and '.join(tried)} took {count} requests, then failed ({_why(error)})"
                    raise Missing(said, _remedy(error)) from None
            else:
                break
        count += 1
    return count


class _NoReceiver(OSError):
    """An answer that no receiver of traces gives: a page, or one from another address."""


def _post(endpoint: str, body: bytes, headers: Mapping[str, str]) -> None:
    """Post one request.

    Raises:
        OSError: If it is not accepted as a whole, also where a page is the answer.
        HTTPException: If the answer is no HTTP.
    """
    post = urllib.request.Request(endpoint, body, dict(headers), method="POST")  # noqa: S310 - the scheme is checked
    with urllib.request.urlopen(post, timeout=_TIMEOUT) as answer:  # noqa: S310 - the scheme is checked
        if answer.url != endpoint:
            raise _NoReceiver(f"it redirects to {answer.url}")
        if answer.headers.get_content_type() == "text/html":
            raise _NoReceiver("it answers with a page")
        if said := _rejected(answer.read(_LARGEST_ANSWER)):
            raise OSError(said)


def _rejected(answer: bytes) -> str:
    """What a receiver says of spans that it did not take; empty if it took all, or says so in protobuf."""
    try:
        partly = json.loads(answer)["partialSuccess"]
        count, why = int(partly.get("rejectedSpans") or 0), str(partly.get("errorMessage") or "it gives no reason")
    except (ValueError, TypeError, LookupError, AttributeError, RecursionError):
        return ""
    return f"it rejected {count} spans: {why[:200]}" if count else ""


def _is_elsewhere(error: Exception) -> bool:
    """Whether a receiver may be at another path of the same server."""
    return isinstance(error, _NoReceiver) or (isinstance(error, urllib.error.HTTPError) and error.code in _NOT_HERE)


def _headers() -> dict[str, str]:
    found: dict[str, str] = {}
    for pair in filter(str.strip, os.environ.get(_HEADERS, "").split(",")):
        name, equals, value = pair.partition("=")
        name, value = name.strip(), unquote(value.strip())
        if not equals or not _NAME.fullmatch(name) or not value.isprintable() or not value.isascii():
            raise BadValue(_HEADERS, "an invalid header", "NAME=VALUE,NAME=VALUE")  # its value may be a key
        found[name] = value
    return found


def _encoded(request: Mapping[str, object]) -> tuple[bytes, str]:
    """The body of a request and its content type. IDs are hexadecimal in OTLP's JSON, base64 in protobuf's JSON."""
    try:
        from google.protobuf.json_format import ParseDict
        from opentelemetry.proto.collector.trace.v1.trace_service_pb2 import ExportTraceServiceRequest
    except ImportError:
        return json.dumps(request, ensure_ascii=False, allow_nan=False).encode(), "application/json"
    parsed = ParseDict(_with_base64(request), ExportTraceServiceRequest())
    return parsed.SerializeToString(), "application/x-protobuf"


def _with_base64(value: Any) -> Any:
    if isinstance(value, list):
        return [_with_base64(one) for one in value]
    if not isinstance(value, Mapping):
        return value
    return {
        name: base64.b64encode(bytes.fromhex(one)).decode() if name in _IDS else _with_base64(one)
        for name, one in value.items()
    }


def _why(error: Exception) -> str:
    if isinstance(error, urllib.error.HTTPError):
        return f"status {error.code}"
    reason = error.reason if isinstance(error, urllib.error.URLError) else error
    return readable(str(reason) or type(error).__name__).replace("\n", " ")


def _remedy(error: Exception) -> str:
    if isinstance(error, urllib.error.HTTPError) and error.code == 415:
        return "it takes protobuf only: pip install 'lockprobe[otel]'"
    return "check the address, or write a file with --out FILE"
