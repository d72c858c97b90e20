"""From a spec and the environment to the bytes that are sent and the facts that are kept, or to a refusal in one line."""

import json

import pytest

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm.model_facts import ModelFacts
from lockprobe.agents.llm.servers import PROVIDERS, Server, request_body
from lockprobe.agents.llm.settings import Access, Model, ModelSettings
from lockprobe.agents.prompt import Message
from lockprobe.foundation.errors import BadValue, Missing, UnknownName, UserMistake
from lockprobe.foundation.spec import Spec, with_options
from lockprobe.plants.catalogue import known_plants
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
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
KEY = "sk-private-0123456789"


@pytest.fixture(autouse=True)
def keys(monkeypatch, own_environment):
    monkeypatch.setenv("AZURE_BASE_URL", "https://x.openai.azure.com/openai/v1")
    monkeypatch.setenv("FAKE_BASE_URL", "http://127.0.0.1:9/v1")
    for name in (*PROVIDERS, "AZURE", "XAI"):
        monkeypatch.setenv(f"{name.upper()}_API_KEY", KEY)


def sent(spec):
    """The body of a request as text."""
    model = Model.parse(spec)
    return request_body(Server.of(model.name), model, SAID, FORM).decode()


def test_a_request_of_chat_completions_byte_for_byte():
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
        ("vllm/Qwen/Q", {"model": "Qwen/Q"}, "max_tokens max_completion_tokens temperature top_p reasoning_effort"),
        ("openai/o1-2024-12-17", {"max_completion_tokens": 25_000}, "max_tokens"),
        ("openai/gpt-4o-audio-preview", {}, "max_tokens max_completion_tokens"),
    ],
)  # fmt: skip
def test_what_a_provider_calls_otherwise_is_sent_under_its_name(spec, there, gone):
    body = json.loads(sent(spec))
    assert body.items() >= there.items()
    assert not set(gone.split()) & body.keys()


@pytest.mark.parametrize(
    ("spec", "there", "output"),
    [
        ("claude-sonnet-4-5", {"max_tokens": 1000}, {}),
        ("claude-sonnet-4-5?effort=high", {"max_tokens": 25_000, "thinking": {"type": "enabled", "budget_tokens": 16_000}}, {}),
        ("claude-3-7-sonnet?effort=max&max_tokens=9", {"thinking": {"type": "enabled", "budget_tokens": 8}}, {}),
        ("claude-opus-5?effort=high", {"max_tokens": 25_000, "thinking": {"type": "adaptive"}}, {"effort": "high"}),
        ("claude-opus-5?effort=none", {"max_tokens": 1000, "thinking": {"type": "disabled"}}, {}),
        ("claude-sonnet-5-5?effort=none", {"thinking": {"type": "between_tools"}}, {}),
        ("claude-unheard-9?temperature=1", {"max_tokens": 32_000, "temperature": 1.0}, {}),
    ],
)  # fmt: skip
def test_anthropic_is_asked_in_its_own_form_with_its_cache_and_the_form_of_the_reply(spec, there, output):
    body, name = json.loads(sent(f"anthropic/{spec}")), spec.partition("?")[0]
    image = {"type": "image", "source": {"type": "base64", "media_type": "image/png", "data": "cG5n"}}
    assert body["messages"][0] == {"role": "user", "content": [{"type": "text", "text": "Now?"}, image]}
    assert [message["role"] for message in body["messages"]] == ["user", "assistant", "user"]
    assert (body["model"], body["cache_control"]) == (name, {"type": "ephemeral"})
    assert body["output_config"] == output | {"format": {"type": "json_schema", "schema": FORM}}
    assert body.items() >= there.items()
    server = Server.of(f"anthropic/{name}")
    assert server.url == "https://api.anthropic.com/v1/messages"
    assert server.headers.items() >= {"x-api-key": KEY, "anthropic-version": "2023-06-01"}.items()
    assert "authorization" not in server.headers
    assert "output_config" not in sent("anthropic/claude-sonnet-4-5?schema=none")


LEFT = dict.fromkeys(("temperature", "top_p", "effort", "max_tokens"), "provider default")


@pytest.mark.parametrize(
    ("facts", "options", "kept"),
    [
        ({}, "", LEFT | {"schema": "strict", "repairs": 4}),
        ({}, "temperature=0&top_p=0.5&effort=low&max_tokens=77", {"temperature": 0.0, "top_p": 0.5, "effort": "low", "max_tokens": 77}),
        ({}, "images=2&detail=low", {"images": 2, "detail": "low"}),
        ({"schema": "loose"}, "", {"schema": "loose"}),
        ({"reasons": False, "most_output": 16_384}, "", {"max_tokens": 1000}),
        ({"reasons": False, "most_output": 16_384}, "effort=high", {"max_tokens": 16_384}),
        ({"reasons": True, "most_output": 100_000}, "", {"max_tokens": 25_000}),
        ({"reasons": True, "most_output": 100_000}, "effort=none", {"max_tokens": 1000}),
        ({"reasons": True}, "max_tokens=5", {"max_tokens": 5}),
        ({"price": None, "picture_tokens": 9, "most_output": 9}, "", LEFT),
    ],
)  # fmt: skip
def test_the_record_says_what_was_sent_what_is_fixed_and_what_the_provider_decides(facts, options, kept):
    asked = with_options(ModelSettings, "a/b", Spec.parse(f"a/b?{options}" if options else "a/b").options)
    model = Model(name="a/b", settings=asked, facts=ModelFacts(**facts))
    assert model.sent().items() >= kept.items()
    if options == "" and not facts:
        assert (model.sent(), model.parameters()) == (kept, {})


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("a/b?heat=1", "no option of llm:a/b is called 'heat'"),
        ("openai-api/a/b?image=4", "no option of llm:openai-api/a/b is called 'image' (did you mean 'images'?)"),
        ("a/b?temperature=nan", "temperature: got nan, expected a number from 0 to 2"),
        ("a/b?temperature=2.1", "temperature: got 2.1, expected a number from 0 to 2"),
        ("a/b?top_p=0", "top_p: got 0.0, expected a number from 0.001 to 1"),
        ("a/b?max_tokens=0", "max_tokens: got 0, expected a whole number from 1 to 10000000"),
        ("a/b?effort=huge", "effort: got 'huge', expected one of none, minimal, low, medium, high, xhigh, max"),
        ("a/b?repairs=21", "repairs: got 21, expected a whole number from 0 to 20"),
        ("a//b", "language model: got 'a//b', expected PROVIDER/MODEL such as openai/gpt-4o, local or gguf:PATH"),
        ("openai/gpt-4o?upstream=x", "upstream cannot be combined with llm:openai/gpt-4o"),
    ],
)  # fmt: skip
def test_an_option_that_cannot_be_or_that_a_model_refuses_is_one_line_before_anything_is_played(spec, message):
    with pytest.raises(UserMistake) as wrong:
        resolve(f"llm:{spec}")
    assert isinstance(wrong.value, UnknownName if message.startswith("no ") else BadValue)
    assert str(wrong.value).startswith(message)


@pytest.mark.parametrize(
    "wrong", ["connections=0", "connections=10001", "timeout=0", "timeout=86401", "pause=-1", "pause=60.5"]
)
def test_how_a_provider_is_reached_has_limits(wrong):
    option, value = wrong.split("=")
    with pytest.raises(BadValue, match=f"^{option}: got {value}.*, expected a (whole )?number from"):
        Access(**{option: float(value)})


def test_a_model_known_to_be_blind_is_refused_where_there_are_only_pictures():
    assert "fast-twin" in known_plants()
    pictured = StudyOptions(study="modalities", plant="fast-twin", modality=["rgb"], agent=["llm:openai/o3-mini"])
    with pytest.raises(BadValue, match="symbolic for llm:openai/o3-mini, which reads reports and looks at no pict"):
        study(pictured)
    for looks in ("llm:openai/gpt-4o", "llm:ollama/llava"):
        assert study(pictured.model_copy(update={"agent": [looks]})).modalities == ("rgb",)


@pytest.mark.parametrize(
    ("name", "url", "there", "header", "host"),
    [
        ("openai/gpt-4o", None, "https://api.openai.com/v1/chat/completions", "authorization", None),
        ("openai-api/fake/m", "http://127.0.0.1:1/v1/", "http://127.0.0.1:1/v1/chat/completions", "authorization", "127.0.0.1"),
        ("fake/m", "http://h/v1?api-version=2", "http://h/v1/chat/completions?api-version=2", "authorization", "h"),
        ("fake/m", "https://x.openai.azure.com/openai/v1", "https://x.openai.azure.com/openai/v1/chat/completions", "api-key", "x.openai.azure.com"),
        ("fake/m", "http://user:password@h:8/v1", "http://user:password@h:8/v1/chat/completions", "authorization", "h"),
        ("ollama/llama3.2", None, "http://localhost:11434/v1/chat/completions", "authorization", None),
        ("grok/grok-4.5", None, "https://api.x.ai/v1/chat/completions", "authorization", None),
    ],
)  # fmt: skip
def test_the_server_is_the_providers_own_or_the_one_that_the_environment_names(
    monkeypatch, name, url, there, header, host
):
    if url:
        monkeypatch.setenv("FAKE_BASE_URL", url)
    server = Server.of(name)
    assert (server.url, KEY in server.headers[header], server.host) == (there, True, host)


def test_a_server_on_http_needs_no_key_and_the_record_says_where_a_model_was_asked(monkeypatch):
    monkeypatch.delenv("OLLAMA_API_KEY")
    assert "authorization" not in Server.of("ollama/llama3.2").headers
    assert "host" not in resolve("llm:openai/gpt-4o").make().facts
    monkeypatch.setenv("OPENAI_BASE_URL", "https://gateway.example/v1")
    assert resolve("llm:openai/gpt-4o").make().facts["host"] == "gateway.example"


@pytest.mark.parametrize(
    ("name", "variables", "kind", "message"),
    [
        ("openai/gpt-4o", {"OPENAI_API_KEY": ""}, Missing, "llm:openai/gpt-4o needs OPENAI_API_KEY: export OPENAI_API_KEY=… and run again"),
        ("grok/grok-4.5", {"XAI_API_KEY": ""}, Missing, "llm:grok/grok-4.5 needs XAI_API_KEY: "),
        ("nosuch/x", {}, BadValue, "language model: got 'nosuch/x', expected PROVIDER/MODEL with one of anthropic, "),
        *(
            ("fake/m", {"FAKE_API_KEY": key}, Missing, "FAKE_API_KEY: no request can carry a key with line breaks")
            for key in (" ", "sk-secret\n", "sk-\r\nsecret", "sk-secret\u2026", "\ufeffsk-secret")
        ),
        *(
            ("fake/m", {"FAKE_BASE_URL": url}, BadValue, f"FAKE_BASE_URL: got {url!r}, expected a URL such as http://localhost:8080/v1")
            for url in ("http://localhost:80a0/v1", "http://x:99999/v1", "http://x:0/v1", "localhost:8080/v1", "http://[::1/v1", "http://", "http://a b/v1", "ftp://x/v1", "http://x\x01y/v1")
        ),
        ("fake/m", {"HTTPS_PROXY": "http://me:hidden@x:y"}, BadValue, "[secret]@x:y"),
        ("fake/m", {"https_proxy": "localhost:31z8"}, BadValue, "localhost:31z8"),
        ("fake/m", {"ALL_PROXY": "ftp://x:1"}, BadValue, "ftp://x:1"),
        ("openai/gpt-4o", {"SSL_CERT_FILE": "/nowhere.pem"}, BadValue, "expected proxies and certificates in the environment that can be used"),
        ("openai/gpt-4o", {"SSL_CERT_FILE": "/tmp"}, BadValue, "expected proxies and certificates in the environment that can be used"),
    ],
)  # fmt: skip
def test_an_environment_that_cannot_be_used_is_one_line_without_keys(monkeypatch, name, variables, kind, message):
    for variable, value in variables.items():
        monkeypatch.setenv(variable, value)
    with pytest.raises(kind) as wrong:
        resolve(f"llm:{name}").check()
    assert message in str(wrong.value)
    assert "\n" not in str(wrong.value)
    assert "hidden" not in str(wrong.value)
    assert "sk-" not in str(wrong.value)


def most(text="What now?", sizes=(), max_tokens=None, **facts):
    """The largest usage of a call with pictures of these sizes, of which as much is there as says how large they are."""
    head = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR"
    pngs = [head + width.to_bytes(4, "big") + height.to_bytes(4, "big") for width, height in sizes]
    said = Message(role="user", text=text, pictures=tuple(Picture(kind="rgb", png=png) for png in pngs))
    model = Model(name="a/b", settings=ModelSettings(max_tokens=max_tokens), facts=ModelFacts(**facts))
    return model.at_most([said])


def test_what_a_reply_may_take_is_what_is_asked_for_and_every_block_of_every_picture_counts():
    asked = ({"max_tokens": 55}, {"reasons": False}, {"reasons": True}, {}, {"most_output": 900})
    assert [most(**one).output_tokens for one in asked] == [55, 1000, 25_000, 32_768, 900]
    assert most().input_tokens == len("What now?") + 20 + 500  # marks of a message, and the form of the reply
    square, two = [(1024, 1024)], [(64, 64)] * 2
    for sizes, blocks in (square, 1), ([(0, 0)], 1), ([(1025, 1024)], 2), (two, 2), ([(4096, 4096)], 16):
        for known, each in ({}, 3000), ({"picture_tokens": 765}, 765):
            assert most(sizes=sizes, **known).input_tokens - most(**known).input_tokens == blocks * each
