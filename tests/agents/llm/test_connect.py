"""Models opened: what is missing is said in one line before anything is asked."""

import os

import pytest

from lockprobe.agents.model_access import Access
from lockprobe.foundation.errors import BadValue, Missing

opening = pytest.importorskip("lockprobe.agents.llm.connect")
MODEL = "openai-api/fake/model"


@pytest.fixture(autouse=True)
def own_environment(monkeypatch):
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL")):
            monkeypatch.delenv(name)
    for provider in ("FAKE", "OPENAI"):
        monkeypatch.setenv(f"{provider}_API_KEY", "sk-private-0123456789")


@pytest.mark.parametrize(
    ("provider", "variable", "package"),
    [("vllm", "VLLM", "vllm"), ("vllm-completions", "VLLM", "vllm"), ("sglang", "SGLANG", "sglang")],
)
def test_a_server_that_is_not_named_and_cannot_be_started_is_missing(monkeypatch, capfd, provider, variable, package):
    monkeypatch.setattr(opening, "find_spec", lambda name: None)
    with pytest.raises(Missing) as missing:
        opening.opened(f"{provider}/x", Access(), {})
    assert str(missing.value) == (
        f"llm:{provider}/x needs a server: export {variable}_BASE_URL=http://HOST:PORT/v1 of a running server, "
        f"or pip install {package} to start one"
    )
    assert capfd.readouterr().out == ""


def test_a_server_that_is_named_is_asked_again_by_nobody_but_us(monkeypatch):
    monkeypatch.setenv("VLLM_BASE_URL", "http://127.0.0.1:9/v1")
    model = opening.opened("vllm/named", Access(), {})
    assert (model.api.client.max_retries, model.api.client.timeout) == (0, None)
    assert str(model.api.client.base_url) == "http://127.0.0.1:9/v1/"


@pytest.mark.parametrize(
    ("said", "line"),
    [
        ("No CLOUDFLARE_ACCOUNT_ID defined", "llm:a/b needs CLOUDFLARE_ACCOUNT_ID: export CLOUDFLARE_ACCOUNT_ID=… and"),
        ("[bold]ERROR[/bold]: set [blue]A_TOKEN[/blue] first", "llm:a/b needs A_TOKEN: export A_TOKEN=… and run again"),
        ("No module named 'vllm'", "llm:a/b needs the package vllm: pip install vllm"),
        ("try [bold]pip install groq[/bold]", "llm:a/b needs the package groq: pip install groq"),
        ("no such thing", "language model: got 'a/b', expected PROVIDER/MODEL as Inspect AI names it (no such thing)"),
    ],
)
def test_what_inspect_says_is_one_line_of_ours(said, line):
    assert str(opening.mistake("a/b", ValueError(said))).startswith(line)


@pytest.mark.parametrize(
    ("model", "name", "url", "host"),
    [
        (MODEL, "FAKE_BASE_URL", "http://user:password@models.example:8080/v1?key=1", "models.example"),
        ("openai/gpt-4o", "OPENAI_BASE_URL", "https://gateway.example/openai", "gateway.example"),
        ("openai/gpt-4o", "OTHER_BASE_URL", "https://gateway.example/openai", None),
    ],
)
def test_the_host_is_said_where_it_is_not_the_providers_own(monkeypatch, model, name, url, host):
    monkeypatch.setenv(name, url)
    assert opening.host_of(model) == host


@pytest.mark.parametrize(
    "url",
    ["http://localhost:80a0/v1", "http://x:99999/v1", "localhost:8080/v1", "http://[::1/v1", "http://", "http://a b/v1",
     "ftp://x/v1", "http://x\x01y/v1"],
)  # fmt: skip
def test_a_url_that_is_none_is_one_line(monkeypatch, url):
    monkeypatch.setenv("FAKE_BASE_URL", url)
    with pytest.raises(BadValue) as mistake:
        opening.opened(MODEL, Access(), {})
    assert str(mistake.value) == f"FAKE_BASE_URL: got {url!r}, expected a URL such as http://localhost:8080/v1"


def test_a_proxy_that_is_none_is_one_line(monkeypatch):
    monkeypatch.setenv("FAKE_BASE_URL", "http://localhost:8080/v1")
    monkeypatch.setenv("https_proxy", "localhost:31z8")
    with pytest.raises(BadValue, match="https_proxy: got 'localhost:31z8', expected the URL of a proxy"):
        opening.opened(MODEL, Access(), {})
    monkeypatch.setenv("https_proxy", "localhost:3128")
    opening.opened(MODEL, Access(), {})
