"""By which names a server may be asked for, and what it asks before it lets other machines in."""

import pytest

from lockprobe.foundation.errors import BadValue, Missing
from lockprobe.people.web.address import Address, check_exposure


def test_on_loopback_only_this_machine_is_named():
    address = Address(host="127.0.0.1", port=8765)
    assert address.url == "http://127.0.0.1:8765/"
    assert address.hosts == {"127.0.0.1:8765", "localhost:8765", "[::1]:8765"}
    assert address.origins == {f"http://{host}" for host in address.hosts}
    assert not address.secure


def test_behind_a_proxy_participants_come_under_its_name():
    address = Address(host="127.0.0.1", port=8765, public="https://Study.Example.org:443/")
    assert address.url.lower() == "https://study.example.org:443/"
    assert "https://study.example.org" in address.origins
    assert {"study.example.org", "127.0.0.1:8765"} < address.hosts
    assert address.secure


@pytest.mark.parametrize(
    ("host", "allowed", "url"),
    [
        ("0.0.0.0", ("lab-pc.local",), "http://lab-pc.local:80/"),
        ("192.168.1.5", (), "http://192.168.1.5:80/"),
        ("2001:db8::1", (), "http://[2001:db8::1]:80/"),
    ],
)
def test_on_a_network_it_goes_by_the_names_it_was_given(host, allowed, url):
    address = Address(host=host, port=80, allowed=allowed)
    assert address.url == url.replace(":80/", "/")
    assert address.url.removeprefix("http://").rstrip("/") in address.hosts
    assert "0.0.0.0" not in "".join(address.hosts)


@pytest.mark.parametrize(
    "public",
    [
        "study.example.org",
        "ftp://study.example.org",
        "https://",
        "https://a/b",
        "https://a?b",
        "https://a#b",
        "https://me@a",
        "https://a:0",
        "https://a:99999",
        "https://a b",
        "https://[::1",
        "javascript:alert(1)",
    ],
)
def test_what_is_no_origin_is_refused(public):
    with pytest.raises(BadValue, match="public-url"):
        Address(host="127.0.0.1", port=1, public=public)


@pytest.mark.parametrize("name", ["", "a b", "a:80", "https://a", "a/b", "*"])
def test_what_is_no_name_is_refused(name):
    with pytest.raises(BadValue, match="allow-host"):
        Address(host="127.0.0.1", port=1, allowed=(name,))


def test_a_server_that_listens_everywhere_needs_a_name():
    check_exposure("127.0.0.1", "", ())
    check_exposure("0.0.0.0", "https://a.example", ())
    check_exposure("0.0.0.0", "", ("lab-pc",))
    check_exposure("192.168.1.5", "", ())
    with pytest.raises(Missing, match="--public-url"):
        check_exposure("0.0.0.0", "", ())
