"""Who serves a model, and how a conversation is sent there: as chat completions, or as Anthropic's messages.

``PROVIDER/MODEL`` is one of :data:`PROVIDERS`. ``openai-api/SERVICE/MODEL``, or any other word in the place of the
provider, is a server with the interface of chat completions whose URL is in ``SERVICE_BASE_URL``.
"""

from __future__ import annotations

import base64
import json
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from lockprobe.agents.llm.model_facts import ModelFacts, Schema
from lockprobe.agents.llm.network_settings import check_certificates, check_key, check_proxies, is_url
from lockprobe.agents.llm.settings import ModelSettings
from lockprobe.agents.prompt import Message
from lockprobe.foundation.errors import BadValue, Missing

PROVIDERS = {
    "anthropic": "https://api.anthropic.com/v1",
    "deepseek": "https://api.deepseek.com/v1",
    "fireworks": "https://api.fireworks.ai/inference/v1",
    "google": "https://generativelanguage.googleapis.com/v1beta/openai",
    "grok": "https://api.x.ai/v1",
    "groq": "https://api.groq.com/openai/v1",
    "mistral": "https://api.mistral.ai/v1",
    "openai": "https://api.openai.com/v1",
    "openrouter": "https://openrouter.ai/api/v1",
    "together": "https://api.together.xyz/v1",
    "llamacpp": "http://localhost:8080/v1",
    "lmstudio": "http://localhost:1234/v1",
    "ollama": "http://localhost:11434/v1",
    "sglang": "http://localhost:30000/v1",
    "vllm": "http://localhost:8000/v1",
}
"""Provider -> where it is asked unless ``PROVIDER_BASE_URL`` says otherwise."""

_KEYS = {"grok": "XAI"}
"""How the variables of a provider begin, where they do not begin with its name."""

_THINKING = {"minimal": 2_048, "low": 4_096, "medium": 10_000, "high": 16_000, "xhigh": 32_000, "max": 32_000}
"""Tokens of thinking that an effort stands for, of Claude before 4.6, which takes no effort."""

_BEFORE_EFFORTS = re.compile(r"claude-3|claude-(?:opus|sonnet|haiku)-4(?:-[0-5])?(?:-2\d{7}|$|@)")


@dataclass(frozen=True, slots=True, kw_only=True)
class Server:
    """Where a model is served.

    Attributes:
        provider: As the name of the model has it.
        model: The model as it is sent.
        url: Where conversations are sent.
        key: The key; empty if none is sent.
        messages: Whether it is asked in the form of Anthropic's messages.
    """

    provider: str
    model: str
    url: str
    key: str
    messages: bool

    @property
    def runtime(self) -> str:
        """The form in which it is asked, for the record."""
        return "Anthropic messages" if self.messages else "chat completions"

    @property
    def headers(self) -> dict[str, str]:
        """The headers of every request. Answers that are compressed otherwise would have no bound on their size."""
        usual = {"content-type": "application/json", "accept": "application/json", "accept-encoding": "gzip, deflate"}
        if self.messages:
            return usual | {"x-api-key": self.key, "anthropic-version": "2023-06-01"}
        if _host(self.url).endswith(".azure.com"):
            return usual | {"api-key": self.key}
        return usual | ({"authorization": f"Bearer {self.key}"} if self.key else {})


def server_of(name: str) -> Server:
    """The server of a model by its name without options, with what the environment says of it.

    Raises:
        BadValue: If there is no such provider, or the environment names an invalid server, proxy or certificates.
        Missing: If a key is missing, or no request can carry it.
    """
    provider, variables, model = _parts(name)
    url = os.environ.get(f"{variables}_BASE_URL") or PROVIDERS.get(provider)
    if url is None:
        known = f"PROVIDER/MODEL with one of {', '.join(PROVIDERS)}"
        raise BadValue("language model", name, f"{known}, or {variables}_BASE_URL with the URL of its server")
    if not is_url(url, ("http", "https")):
        raise BadValue(f"{variables}_BASE_URL", url, "a URL such as http://localhost:8080/v1")
    check_key(f"{variables}_API_KEY")
    key = os.environ.get(f"{variables}_API_KEY", "")
    if not key and url.startswith("https:"):
        raise Missing(f"llm:{name} needs {variables}_API_KEY", f"export {variables}_API_KEY=… and run again")
    check_proxies()
    check_certificates()
    messages = name.startswith("anthropic/")
    place, mark, query = url.partition("?")
    path = "messages" if messages else "chat/completions"
    return Server(
        provider=provider, model=model, url=f"{place.rstrip('/')}/{path}{mark}{query}", key=key, messages=messages
    )


def host_of(name: str) -> str | None:
    """The host configured for a model; None for the provider's own."""
    url = os.environ.get(f"{_parts(name)[1]}_BASE_URL")
    return _host(url) or None if url else None


def _host(url: str) -> str:
    try:
        return urlsplit(url).hostname or ""
    except ValueError:
        return ""


def _parts(name: str) -> tuple[str, str, str]:
    """Provider, how its variables begin, and the model as it is sent."""
    provider, _, model = name.partition("/")
    if provider == "openai-api":
        provider, _, model = model.partition("/")
    return provider, _KEYS.get(provider, provider).upper().replace("-", "_"), model


def request_body(
    server: Server,
    messages: Sequence[Message],
    schema: dict[str, object],
    settings: ModelSettings,
    facts: ModelFacts,
) -> bytes:
    """A conversation as it is sent, with the form of the reply and what is set of the model."""
    sent, form = settings.parameters(facts), settings.form(facts)
    if server.messages:
        body = _as_messages(server.model, messages, None if form == "none" else schema, sent)
    else:
        said = [{"role": one.role, "content": _content(one, settings.detail)} for one in messages]
        openai = server.provider == "openai" or _host(server.url).endswith(".azure.com")
        if openai and "max_tokens" in sent and facts.reasons is not False:  # models that reason refuse the older name
            sent["max_completion_tokens"] = sent.pop("max_tokens")
        body = {"messages": said, "model": server.model} | _of_completions(server.provider, schema, sent, form)
    return json.dumps(body, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "replace")


def _of_completions(
    provider: str, schema: dict[str, object], sent: dict[str, object], form: Schema
) -> dict[str, object]:
    """What is set, and the form of the reply, as chat completions have it."""
    body = dict(sent)
    if provider == "openrouter":
        if upstream := body.pop("upstream", None):
            body["provider"] = {"only": [upstream], "allow_fallbacks": False}
        if effort := body.pop("reasoning_effort", None):
            body["reasoning"] = {"effort": effort}
    if form != "none" and provider == "deepseek":
        body["response_format"] = {"type": "json_object"}
    elif form != "none":
        order = ("type", "properties", "additionalProperties", "required")
        ordered = {name: schema[name] for name in order if name in schema}
        asked = {"name": "reply", "schema": ordered, "description": None, "strict": form == "strict"}
        body["response_format"] = {"type": "json_schema", "json_schema": asked}
    return body


def _content(message: Message, detail: str) -> str | list[dict[str, Any]]:
    if not message.pictures:
        return message.text
    parts: list[dict[str, Any]] = [{"type": "text", "text": message.text}]
    for picture in message.pictures:
        url = f"data:image/png;base64,{base64.b64encode(picture.png).decode('ascii')}"
        parts.append({"type": "image_url", "image_url": {"url": url, "detail": detail}})
    return parts


def _as_messages(
    model: str, messages: Sequence[Message], schema: dict[str, object] | None, sent: dict[str, object]
) -> dict[str, object]:
    said = []
    for one in messages:
        parts: list[dict[str, Any]] = [{"type": "text", "text": one.text}]
        for picture in one.pictures:
            data = base64.b64encode(picture.png).decode("ascii")
            parts.append({"type": "image", "source": {"type": "base64", "media_type": "image/png", "data": data}})
        said.append({"role": one.role, "content": parts})
    effort, most = sent.pop("reasoning_effort", None), sent.pop("max_tokens")
    # what every request of a trial begins with is put into the cache, and read from there in the next step
    body = {"model": model, "max_tokens": most, "messages": said, "cache_control": {"type": "ephemeral"}, **sent}
    output: dict[str, Any] = {}
    if effort == "none":
        body["thinking"] = {"type": "between_tools" if "sonnet-5-5" in model else "disabled"}
    elif effort is not None and _BEFORE_EFFORTS.search(model):
        body["thinking"] = {"type": "enabled", "budget_tokens": min(_THINKING[str(effort)], int(str(most)) - 1)}
    elif effort is not None:
        body["thinking"] = {"type": "adaptive"}
        output["effort"] = "low" if effort == "minimal" else effort
    if schema is not None:
        output["format"] = {"type": "json_schema", "schema": schema}
    return body | ({"output_config": output} if output else {})
