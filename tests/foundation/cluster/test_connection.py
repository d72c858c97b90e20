"""Addresses, and clusters that do not answer."""

import socket
import sys

import pytest

from lockprobe.foundation.cluster import Cluster
from lockprobe.foundation.cluster.connection import _standard_error, _unreachable
from lockprobe.foundation.errors import BadValue, Missing


@pytest.mark.parametrize("address", ["", "here", "host:", ":1", "host:0", "host:x", "ray://host:1", "host:99999"])
def test_what_is_no_address_is_refused(address):
    with pytest.raises(BadValue, match="auto, or HOST:PORT of the head node"), Cluster.connect(address):
        pass


def test_where_nobody_listens_nobody_waits():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(Missing, match=f"no Ray cluster answers at {address}"), Cluster.connect(address):
            pass


def test_without_ray_it_is_said_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    with (
        pytest.raises(Missing, match=r"--cluster needs the package ray: pip install 'lockprobe\[cluster\]'"),
        Cluster.connect("auto"),
    ):
        pass


@pytest.mark.parametrize(
    ("error", "written", "line"),
    [
        (ConnectionError("x"), "RPC error: InvalidAuthToken", "the Ray cluster at auto has another token"),
        (RuntimeError("Token authentication is enabled but"), "", "no token for a Ray cluster is here"),
        (RuntimeError("Version mismatch:\n Ray 2.59.0"), "", r"has other versions \(Version mismatch: Ray 2.59.0\)"),
        (ConnectionError("Could not find any running Ray instance"), "", "no Ray cluster runs on this machine"),
        (ValueError("odd\x1b[0m\nthing"), "", "cannot be used: odd.*thing"),
    ],
)
def test_what_ray_says_is_one_line(error, written, line):
    with pytest.raises(Missing, match=line) as raised:
        raise _unreachable("auto", error, written)
    assert str(raised.value).isprintable()


def test_what_libraries_write_is_kept_for_the_message(capfd):
    with _standard_error() as said:
        print("noise", file=sys.__stderr__, flush=True)
    assert "noise" in said[0] or said == [""]  # where the test's own capture stands before it
    print("shown", file=sys.stderr)
    assert "noise" not in capfd.readouterr().err
