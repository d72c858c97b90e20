"""Who is asked, with which key and in which form: byte for byte what was sent before, and for Anthropic its own form."""

import json
import os

import pytest

from lockprobe.agents.llm.model_facts import facts_of
from lockprobe.agents.llm.servers import PROVIDERS, host_of, request_body, server_of
from lockprobe.agents.llm.settings import read_settings
from lockprobe.agents.prompt import Message
from lockprobe.foundation.errors import BadValue, Missing
from lockprobe.trial.pictures.picture import Picture

FORM = {
    "type": "object",
    "properties": {"joint": {"enum": ["Ä"]}},
    "required": ["joint"],
    "additionalProperties": False,
}
SENT_FORM = '{"type":"object","properties":{"joint":{"enum":["Ä"]}},"additionalProperties":false,"required":["joint"]}'
SAID = [
    Message(role="user", text="Now?", pictures=(Picture(kind="rgb", png=b"png"),)),
    Message(role="assistant", text="A"),
    Message(role="user", text="It moved."),
]


@pytest.fixture(autouse=True)
def own_environment(monkeypatch):
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL", "_PROXY", "_proxy")):
            monkeypatch.delenv(name)
    monkeypatch.setenv("AZURE_BASE_URL", "https://x.openai.azure.com/openai/v1")
    for name in (*PROVIDERS, "AZURE", "FAKE", "XAI"):
        monkeypatch.setenv(f"{name.upper()}_API_KEY", "sk-private-0123456789")


def sent(spec, said=SAID):
    """The body of a request as text."""
    name, settings = read_settings(spec)
    return request_body(server_of(name), said, FORM, settings, facts_of(name)).decode()


def test_a_request_of_chat_completions_is_byte_for_byte_what_it_was_through_the_framework(monkeypatch):
    monkeypatch.setenv("FAKE_BASE_URL", "http://127.0.0.1:9/v1")
    picture = '{"type":"image_url","image_url":{"url":"data:image/png;base64,cG5n","detail":"%s"}}'
    said = '{"messages":[{"role":"user","content":[{"type":"text","text":"Now?"},' + picture + "]},"
    said += '{"role":"assistant","content":"A"},{"role":"user","content":"It moved."}],'
    form = '"response_format":{"type":"json_schema","json_schema":{"name":"reply","schema":%s,"description":null,"strict":%s}}}'
    assert sent("openai/gpt-4o?temperature=0.5&top_p=0.3") == (
        said % "high" + '"model":"gpt-4o","max_tokens":1000,"temperature":0.5,"top_p":0.3,' + form % (SENT_FORM, "true")
    )
    assert sent("openai-api/fake/m?temperature=0&effort=low&max_tokens=7&schema=loose&detail=low") == (
        said % "low"
        + '"model":"m","max_tokens":7,"temperature":0.0,"reasoning_effort":"low",'
        + form % (SENT_FORM, "false")
    )
    assert sent("openai-api/fake/m?schema=none") == said % "high" + '"model":"m"}'
    assert sent("deepseek/deepseek-chat").endswith('"max_tokens":1000,"response_format":{"type":"json_object"}}')


@pytest.mark.parametrize(
    ("spec", "there", "gone"),
    [
        ("openai/o1?effort=low", {"max_completion_tokens": 25_000, "reasoning_effort": "low"}, "max_tokens temperature"),
        ("openai/gpt-5.1?effort=none&temperature=0", {"max_completion_tokens": 1000, "temperature": 0.0}, "max_tokens"),
        ("openai/new?max_tokens=5", {"max_completion_tokens": 5}, "max_tokens"),
        ("openai-api/azure/o1?max_tokens=5", {"max_completion_tokens": 5}, "max_tokens"),
        ("openrouter/a/b?effort=low", {"model": "a/b", "reasoning": {"effort": "low"}}, "reasoning_effort provider"),
        ("openrouter/a/b?upstream=DeepInfra", {"provider": {"only": ["DeepInfra"], "allow_fallbacks": False}}, "upstream"),
        ("grok/grok-4.5?effort=low", {"max_tokens": 25_000, "reasoning_effort": "low"}, "max_completion_tokens"),
        ("vllm/Qwen/Q", {"model": "Qwen/Q"}, "max_tokens max_completion_tokens"),
    ],
)  # fmt: skip
def test_what_a_provider_calls_otherwise_is_sent_under_its_name(spec, there, gone):
    body = json.loads(sent(spec))
    assert body.items() >= there.items()
    assert not set(gone.split()) & body.keys()


@pytest.mark.parametrize(
    ("spec", "there"),
    [
        ("claude-sonnet-4-5", {"max_tokens": 1000}),
        ("claude-sonnet-4-5?effort=high", {"max_tokens": 25_000, "thinking": {"type": "enabled", "budget_tokens": 16_000}}),
        ("claude-opus-5?effort=high", {"max_tokens": 25_000, "thinking": {"type": "adaptive"}}),
        ("claude-opus-5?effort=none", {"max_tokens": 1000, "thinking": {"type": "disabled"}}),
        ("claude-sonnet-5-5?effort=none", {"thinking": {"type": "between_tools"}}),
        ("claude-unheard-9?temperature=1", {"max_tokens": 32_000, "temperature": 1.0}),
    ],
)  # fmt: skip
def test_anthropic_is_asked_in_its_own_form_with_its_cache_and_the_form_of_the_reply(spec, there):
    body, text = json.loads(sent(f"anthropic/{spec}")), {"type": "text", "text": "Now?"}
    image = {"type": "image", "source": {"type": "base64", "media_type": "image/png", "data": "cG5n"}}
    assert body["messages"][0] == {"role": "user", "content": [text, image]}
    assert [message["role"] for message in body["messages"]] == ["user", "assistant", "user"]
    assert (body["model"], body["cache_control"]) == (spec.partition("?")[0], {"type": "ephemeral"})
    assert body["output_config"]["format"] == {"type": "json_schema", "schema": FORM}
    assert body["output_config"].get("effort") == ("high" if "opus-5?effort=high" in spec else None)
    assert body.items() >= there.items()
    server = server_of(f"anthropic/{spec.partition('?')[0]}")
    assert server.url == "https://api.anthropic.com/v1/messages"
    assert server.headers.items() >= {"x-api-key": server.key, "anthropic-version": "2023-06-01"}.items()
    assert "authorization" not in server.headers
    assert "output_config" not in sent("anthropic/claude-sonnet-4-5?schema=none")


@pytest.mark.parametrize(
    ("name", "url", "there", "header"),
    [
        ("openai/gpt-4o", None, "https://api.openai.com/v1/chat/completions", "authorization"),
        ("openai-api/fake/m", "http://127.0.0.1:1/v1/", "http://127.0.0.1:1/v1/chat/completions", "authorization"),
        ("fake/m", "http://h/v1?api-version=2", "http://h/v1/chat/completions?api-version=2", "authorization"),
        ("fake/m", "https://x.openai.azure.com/openai/v1", "https://x.openai.azure.com/openai/v1/chat/completions", "api-key"),
        ("ollama/llama3.2", None, "http://localhost:11434/v1/chat/completions", "authorization"),
        ("grok/grok-4.5", None, "https://api.x.ai/v1/chat/completions", "authorization"),
    ],
)  # fmt: skip
def test_the_server_is_the_providers_own_or_the_one_that_the_environment_names(monkeypatch, name, url, there, header):
    if url:
        monkeypatch.setenv("FAKE_BASE_URL", url)
    server = server_of(name)
    assert (server.url, "sk-private-0123456789" in server.headers[header]) == (there, True)


def test_a_server_on_http_needs_no_key_and_one_on_https_does(monkeypatch):
    for name in ("OPENAI", "OLLAMA", "XAI"):
        monkeypatch.delenv(f"{name}_API_KEY")
    assert "authorization" not in server_of("ollama/llama3.2").headers
    with pytest.raises(
        Missing, match=r"^llm:openai/gpt-4o needs OPENAI_API_KEY: export OPENAI_API_KEY=… and run again$"
    ):
        server_of("openai/gpt-4o")
    with pytest.raises(Missing, match=r"^llm:grok/grok-4.5 needs XAI_API_KEY: "):
        server_of("grok/grok-4.5")
    with pytest.raises(
        BadValue, match=r"got 'nosuch/x', expected PROVIDER/MODEL with one of .*, or NOSUCH_BASE_URL with"
    ):
        server_of("nosuch/x")


@pytest.mark.parametrize(
    ("model", "name", "url", "host"),
    [
        ("openai-api/fake/m", "FAKE_BASE_URL", "http://user:password@models.example:8080/v1?key=1", "models.example"),
        ("openai/gpt-4o", "OPENAI_BASE_URL", "https://gateway.example/openai", "gateway.example"),
        ("openai/gpt-4o", "OTHER_BASE_URL", "https://gateway.example/openai", None),
    ],
)
def test_the_host_is_said_where_it_is_not_the_providers_own(monkeypatch, model, name, url, host):
    monkeypatch.setenv(name, url)
    assert host_of(model) == host


@pytest.mark.parametrize(
    "url",
    ["http://localhost:80a0/v1", "http://x:99999/v1", "localhost:8080/v1", "http://[::1/v1", "http://", "http://a b/v1",
     "ftp://x/v1", "http://x\x01y/v1"],
)  # fmt: skip
def test_a_url_that_is_none_is_one_line(monkeypatch, url):
    monkeypatch.setenv("FAKE_BASE_URL", url)
    with pytest.raises(BadValue) as mistake:
        server_of("openai-api/fake/m")
    assert str(mistake.value) == f"FAKE_BASE_URL: got {url!r}, expected a URL such as http://localhost:8080/v1"


def test_a_proxy_that_is_none_is_one_line(monkeypatch):
    monkeypatch.setenv("https_proxy", "localhost:31z8")
    with pytest.raises(BadValue, match="https_proxy: got 'localhost:31z8', expected the URL of a proxy"):
        server_of("openai/gpt-4o")
    monkeypatch.setenv("https_proxy", "localhost:3128")
    server_of("openai/gpt-4o")
