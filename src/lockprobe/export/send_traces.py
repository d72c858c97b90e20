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

from lockprobe.errors import BadValue, Missing
from lockprobe.terminal_text import readable

__all__ = ["endpoint_of", "send_traces"]

_TIMEOUT = 30.0
_HEADERS = "OTEL_EXPORTER_OTLP_HEADERS"
_NAME = re.compile(r"[A-Za-z0-9!#$%&'*+.^_`|~-]+")
_IDS = ("traceId", "spanId", "parentSpanId")


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

    ``OTEL_EXPORTER_OTLP_HEADERS`` in the environment holds further headers, such as a key, as OpenTelemetry's exporters
    read them: ``NAME=VALUE,NAME=VALUE`` with values as in a URL.

    Raises:
        BadValue: If the URL or the headers are invalid.
        Missing: If the receiver does not answer, or refuses a request.
    """
    endpoint, headers, count = endpoint_of(url), _headers(), 0
    for request in requests:
        body, kind = _encoded(request)
        post = urllib.request.Request(  # noqa: S310 - the scheme is checked
            endpoint, body, {**headers, "Content-Type": kind}, method="POST"
        )
        try:
            with urllib.request.urlopen(post, timeout=_TIMEOUT):  # noqa: S310 - the scheme is checked
                count += 1
        except (OSError, http.client.HTTPException) as error:
            raise Missing(f"{endpoint} took {count} requests, then failed ({_why(error)})", _remedy(error)) from None
    return count


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
