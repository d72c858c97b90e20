"""Proxies and certificates that the environment names: a mistake is one line with the variable and the file."""

import os
from pathlib import Path

import pytest

from lockprobe.agents.llm import network_settings
from lockprobe.agents.llm.network_settings import check_certificates, check_key, check_proxies
from lockprobe.foundation.errors import BadValue, Missing

VARIABLES = ["HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY", "NO_PROXY", "SSL_CERT_FILE", "SSL_CERT_DIR"]


@pytest.fixture(autouse=True)
def nothing_set(monkeypatch):
    for name in VARIABLES:
        monkeypatch.delenv(name, raising=False)
        monkeypatch.delenv(name.lower(), raising=False)


@pytest.fixture
def without_socks(monkeypatch):
    found = network_settings.find_spec
    monkeypatch.setattr(network_settings, "find_spec", lambda name: None if name == "socksio" else found(name))


@pytest.mark.parametrize("variable", ["ALL_PROXY", "all_proxy", "HTTPS_PROXY", "http_proxy"])
@pytest.mark.parametrize("scheme", ["socks5", "socks5h"])
def test_a_socks_proxy_without_its_package_is_named_without_the_password(monkeypatch, without_socks, variable, scheme):
    monkeypatch.setenv(variable, f"{scheme}://me:secret@localhost:1080")
    with pytest.raises(Missing) as refused:
        check_proxies()
    said = str(refused.value)
    assert said.startswith(
        f"{variable}={scheme}://localhost:1080: a SOCKS proxy needs the package socksio: pip install"
    )
    assert "secret" not in said
    assert "\n" not in said


def test_a_socks_proxy_with_its_package_is_one(monkeypatch):
    monkeypatch.setattr(network_settings, "find_spec", lambda name: name)
    monkeypatch.setenv("ALL_PROXY", "socks5://localhost:1080")
    check_proxies()


@pytest.mark.parametrize(
    "url", ["ftp://x:1", "socks4://x:1", "http://", "http://x:y", "http://me:secret@x:99999", "a b"]
)
def test_what_is_no_proxy_is_refused_without_its_password(monkeypatch, url):
    monkeypatch.setenv("HTTPS_PROXY", url)
    with pytest.raises(BadValue, match="HTTPS_PROXY: got ") as refused:
        check_proxies()
    assert "secret" not in str(refused.value)


@pytest.mark.parametrize("url", ["localhost:3128", "http://me:word@localhost:3128", "https://[::1]:1", ""])
def test_proxies_are_urls_with_or_without_a_scheme(monkeypatch, url):
    monkeypatch.setenv("http_proxy", url)
    check_proxies()


@pytest.mark.parametrize(
    "hosts",
    ["*", "localhost,127.0.0.1,::1,[::1],.a.org,*.b.org", "a.org:8080", "", "localhost,,x", "http://a", "10.0.0.0/8"],
)
def test_hosts_without_a_proxy_are_read(monkeypatch, hosts):
    monkeypatch.setenv("NO_PROXY", hosts)
    check_proxies()


@pytest.mark.parametrize("host", ["[::1", "a b", "a:b", "http://", "ftp://x"])
def test_what_is_no_host_is_named(monkeypatch, host):
    monkeypatch.setenv("no_proxy", f"localhost, {host}")
    with pytest.raises(BadValue, match="no_proxy: got ") as refused:
        check_proxies()
    assert host in str(refused.value)


FILES = {
    "missing": None,
    "empty": b"",
    "text": b"no certificate\n",
    "cut": b"-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n",
    "binary": b"\xff\xfe\x00",
}


@pytest.mark.parametrize("kind", [*FILES, "folder", "nul"])
def test_a_file_without_certificates_is_named_with_its_variable(tmp_path, monkeypatch, kind):
    path = tmp_path / kind
    if kind == "folder":
        path.mkdir()
    elif kind == "nul":
        path = Path(f"{path}\nx")
    elif FILES[kind] is not None:
        path.write_bytes(FILES[kind])
    monkeypatch.setenv("SSL_CERT_FILE", str(path))
    with pytest.raises(BadValue, match="SSL_CERT_FILE: got ") as refused:
        check_certificates()
    assert kind in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_a_file_that_cannot_be_read_is_named(tmp_path, monkeypatch):
    (tmp_path / "ca.pem").write_bytes(b"x")
    (tmp_path / "ca.pem").chmod(0)
    monkeypatch.setenv("SSL_CERT_FILE", str(tmp_path / "ca.pem"))
    with pytest.raises(BadValue, match="SSL_CERT_FILE: got .*Permission denied"):
        check_certificates()


def test_folders_have_to_be_there_and_hold_something(tmp_path, monkeypatch):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "0.pem").write_bytes(b"x")
    (tmp_path / "empty").mkdir()
    monkeypatch.setenv("SSL_CERT_DIR", str(tmp_path / "full"))
    check_certificates()
    for wrong in ("missing", "empty", "full/0.pem", f"full{os.pathsep}missing"):
        monkeypatch.setenv("SSL_CERT_DIR", os.pathsep.join(str(tmp_path / part) for part in wrong.split(os.pathsep)))
        with pytest.raises(BadValue, match="SSL_CERT_DIR: got "):
            check_certificates()


def test_certificates_that_can_be_read_pass_and_what_nobody_reads_is_not_looked_at(monkeypatch):
    certifi = pytest.importorskip("certifi")
    monkeypatch.setenv("SSL_CERT_FILE", certifi.where())
    monkeypatch.setenv("SSL_CERT_DIR", "/nowhere")
    check_certificates()


@pytest.mark.parametrize(
    "key", [" ", "sk-secret\n", "sk-\r\nsecret", "sk-secret\u2026", "\ufeffsk-secret", "sk-sec\x00ret"]
)
def test_a_key_that_no_request_can_carry_is_named_and_not_quoted(monkeypatch, key):
    monkeypatch.setattr(network_settings.os, "environ", {"FAKE_API_KEY": key})
    with pytest.raises(Missing, match="^FAKE_API_KEY: no request can carry ") as refused:
        check_key("FAKE_API_KEY")
    assert "sec" not in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("key", [None, "", "sk-secret_0123/+=."])
def test_other_keys_are_left_to_the_provider(monkeypatch, key):
    monkeypatch.setattr(network_settings.os, "environ", {} if key is None else {"FAKE_API_KEY": key})
    check_key("FAKE_API_KEY")


def test_what_is_no_file_is_no_file_of_certificates(monkeypatch, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path, tmp_path / "pipe"):
        monkeypatch.setenv("SSL_CERT_FILE", str(path))
        with pytest.raises(BadValue, match="it is no file"):
            check_certificates()
