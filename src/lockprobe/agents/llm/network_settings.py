"""Checks the variables of the environment that the HTTP library reads: proxies and certificates.

It fails at the first request, in words that name neither the variable nor the file. Here a mistake is one
line, before anything is played.
"""

from __future__ import annotations

import os
import ssl
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import urlsplit

from lockprobe.foundation.errors import BadValue, Missing

_PROXIES = ("HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY")
_NO_PROXY = "NO_PROXY"

_SOCKS = ("socks5", "socks5h")


def check_proxies() -> None:
    """Check the variables with proxies, in upper and lower case.

    Raises:
        BadValue: If one is no URL of a proxy, or ``NO_PROXY`` holds something that is no host.
        Missing: If one is a SOCKS proxy and its package is not installed.
    """
    for variable, url in _set(_PROXIES):
        whole = url if "://" in url else f"http://{url}"
        if not is_url(whole, ("http", "https", *_SOCKS)):
            raise BadValue(variable, _without_password(url), "the URL of a proxy such as http://localhost:3128")
        if urlsplit(whole).scheme in _SOCKS and find_spec("socksio") is None:
            said = f"{variable}={_without_password(url)}: a SOCKS proxy needs the package socksio"
            raise Missing(said, f"pip install socksio, or unset {variable}")
    for variable, hosts in _set((_NO_PROXY,)):
        for host in filter(None, map(str.strip, hosts.split(","))):
            if not _is_host(host):
                raise BadValue(variable, host, "hosts with commas between them, such as localhost,.example.org")


def check_certificates() -> None:
    """Check the variables with certificates.

    Raises:
        BadValue: If one names no readable certificates; the message names the variable and the file.
    """
    own, folders = os.environ.get("SSL_CERT_FILE", ""), os.environ.get("SSL_CERT_DIR", "")
    if own:
        _check_file("SSL_CERT_FILE", own)
    elif folders:
        for folder in folders.split(os.pathsep):
            _check_folder("SSL_CERT_DIR", folder)


def check_key(variable: str) -> None:
    """Check a variable with a key, if it is set: what a header cannot hold is not sent.

    Raises:
        Missing: If it is blank, or holds a line break, a blank at an end or a letter outside ASCII; it is not quoted.
    """
    key = os.environ.get(variable, "")
    if key != key.strip() or not key.isascii() or not key.isprintable():
        said = f"{variable}: no request can carry a key with line breaks, blanks around it or letters outside ASCII"
        raise Missing(said, f"export {variable}=… without them and run again")


def is_url(url: str, schemes: tuple[str, ...]) -> bool:
    """Whether a text is a URL with a host and one of these schemes."""
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError:
        return False
    return bool(parts.scheme in schemes and host and port != 0 and url.isprintable() and " " not in url)


def _set(names: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """The variables of these names that are set, in upper or lower case, with their values."""
    return ((variable, value) for variable, value in os.environ.items() if variable.upper() in names and value)


def _without_password(url: str) -> str:
    scheme, there, rest = url.rpartition("://")
    return f"{scheme}{there}{rest.rpartition('@')[2]}"


def _is_host(host: str) -> bool:
    """Whether the libraries can read a host of ``NO_PROXY``: a name, an address or a URL, with or without a port."""
    if host == "*" or ("://" not in host and host.count(":") > 1 and not host.startswith("[")):  # any; an IPv6 address
        return True
    return is_url(host if "://" in host else f"all://{host.lstrip('*.')}", ("all", "http", "https"))


def _check_file(variable: str, path: str) -> None:
    expected = "a file of certificates (PEM) that can be read"
    if (named := Path(path)).exists() and not named.is_file():
        raise BadValue(variable, path, f"{expected}: it is no file")
    try:
        with named.open("rb"):
            pass
        ssl.create_default_context(cafile=path)
    except ssl.SSLError:
        raise BadValue(variable, path, f"{expected}: it holds none") from None
    except (OSError, ValueError) as error:
        raise BadValue(variable, path, f"{expected} ({getattr(error, 'strerror', None) or error})") from None


def _check_folder(variable: str, path: str) -> None:
    expected = "a folder of certificates that can be read"
    try:
        if not any(Path(path).iterdir()):
            raise BadValue(variable, path, f"{expected}: it is empty")
    except (OSError, ValueError) as error:
        raise BadValue(variable, path, f"{expected} ({getattr(error, 'strerror', None) or error})") from None
