"""Who serves a model, and how a conversation is sent there: as chat completions, or as Anthropic's messages.

``PROVIDER/MODEL`` is one of :data:`PROVIDERS`. ``openai-api/SERVICE/MODEL``, or any other word in the place of the
provider, is a server with the interface of chat completions whose URL is in ``SERVICE_BASE_URL``.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from lockprobe.agents.llm.settings import Model
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

_AZURE = ".azure.com"

_THINKING = {"minimal": 2_048, "low": 4_096, "medium": 10_000, "high": 16_000, "xhigh": 32_000, "max": 32_000}
"""Tokens of thinking that an effort stands for, of Claude before 4.6, which takes no effort."""

_BEFORE_EFFORTS = re.compile(r"claude-3|claude-(?:opus|sonnet|haiku)-4(?:-[0-5])?(?:-2\d{7}|$|@)")


@dataclass(frozen=True, slots=True)
class Server:
    """Where a model is served, by its name; the environment may say otherwise, and has the key.

    Attributes:
        provider: Its provider, or the word in that place.
        model: The model, as it is sent.
        key: Empty for none.
        messages: Whether it is asked as Anthropic's messages.
        host: The host that the environment names; None for the provider's own.
    """

    provider: str
    model: str
    url: str
    key: str
    messages: bool
    host: str | None

    @classmethod
    def of(cls, name: str) -> Server:
        """The server of a model; refused if there is no such provider, or its key is missing or cannot be sent."""
        provider, _, model = name.removeprefix("openai-api/").partition("/")
        variables = {"grok": "xai"}.get(provider, provider).upper().replace("-", "_")
        own, key = os.environ.get(f"{variables}_BASE_URL"), os.environ.get(f"{variables}_API_KEY", "")
        url = own or PROVIDERS.get(provider)
        if url is None:
            known = f"PROVIDER/MODEL with one of {', '.join(PROVIDERS)}"
            raise BadValue("language model", name, f"{known}, or {variables}_BASE_URL with the URL of its server")
        if not _host(url) or not re.fullmatch("https?://[!-~]+", url):
            raise BadValue(f"{variables}_BASE_URL", url, "a URL such as http://localhost:8080/v1")
        if key and not re.fullmatch("[!-~]+( [!-~]+)*", key):
            said = "no request can carry a key with line breaks, blanks around it or letters outside ASCII"
            raise Missing(f"{variables}_API_KEY: {said}", f"export {variables}_API_KEY=… without them and run again")
        if not key and url.startswith("https:"):
            raise Missing(f"llm:{name} needs {variables}_API_KEY", f"export {variables}_API_KEY=… and run again")
        messages = name.startswith("anthropic/")
        place, mark, query = url.partition("?")
        asked = f"{place.rstrip('/')}/{'messages' if messages else 'chat/completions'}{mark}{query}"
        return cls(provider, model, asked, key, messages, _host(own) if own else None)

    @property
    def headers(self) -> dict[str, str]:
        """The headers of every request. Answers that are compressed otherwise would have no bound on their size."""
        usual = {"content-type": "application/json", "accept": "application/json", "accept-encoding": "gzip, deflate"}
        if self.messages:
            return usual | {"x-api-key": self.key, "anthropic-version": "2023-06-01"}
        if _host(self.url).endswith(_AZURE):
            return usual | {"api-key": self.key}
        return usual | ({"authorization": f"Bearer {self.key}"} if self.key else {})


def _host(url: str) -> str:
    """The host of a URL; empty if it has none, or an impossible port."""
    try:
        host, port = urlsplit(url).hostname, urlsplit(url).port
    except ValueError:
        return ""
    return "" if host is None or port == 0 else host


def request_body(server: Server, model: Model, messages: Sequence[Message], schema: dict[str, object]) -> bytes:
    """A conversation as it is sent, with the form of the reply and what is set of the model."""
    said: list[dict[str, Any]] = []
    for message in messages:
        parts: list[dict[str, Any]] = [{"type": "text", "text": message.text}]
        for picture in message.pictures:
            if server.messages:
                source = {"type": "base64", "media_type": "image/png", "data": picture.base64}
                parts.append({"type": "image", "source": source})
            else:
                image = {"url": f"data:image/png;base64,{picture.base64}", "detail": model.settings.detail}
                parts.append({"type": "image_url", "image_url": image})
        whole = parts if server.messages or message.pictures else message.text
        said.append({"role": message.role, "content": whole})
    body = (_as_messages if server.messages else _as_completions)(server, model, said, schema)
    return json.dumps(body, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "replace")


def _as_completions(
    server: Server, model: Model, said: list[dict[str, Any]], schema: dict[str, object]
) -> dict[str, Any]:
    body = {"messages": said, "model": server.model, **model.parameters()}
    older = "max_tokens" in body and model.facts.reasons is not False  # a name that models refuse that reason
    if older and (server.provider == "openai" or _host(server.url).endswith(_AZURE)):
        body["max_completion_tokens"] = body.pop("max_tokens")
    if server.provider == "openrouter":
        if upstream := body.pop("upstream", None):
            body["provider"] = {"only": [upstream], "allow_fallbacks": False}
        if effort := body.pop("reasoning_effort", None):
            body["reasoning"] = {"effort": effort}
    if model.settings.schema == "none":
        return body
    if server.provider == "deepseek":
        return body | {"response_format": {"type": "json_object"}}
    order = ("type", "properties", "additionalProperties", "required")
    ordered = {name: schema[name] for name in order if name in schema}
    asked = {"name": "reply", "schema": ordered, "description": None, "strict": model.settings.schema == "strict"}
    return body | {"response_format": {"type": "json_schema", "json_schema": asked}}


def _as_messages(server: Server, model: Model, said: list[dict[str, Any]], schema: dict[str, object]) -> dict[str, Any]:
    sent: dict[str, Any] = model.parameters()
    effort, most = sent.pop("reasoning_effort", None), sent.pop("max_tokens")
    # what every request of a trial begins with is put into the cache, and read from there in the next step
    body = {"model": server.model, "max_tokens": most, "messages": said, "cache_control": {"type": "ephemeral"}, **sent}
    output: dict[str, Any] = {}
    if effort == "none":
        body["thinking"] = {"type": "between_tools" if "sonnet-5-5" in server.model else "disabled"}
    elif effort is not None and _BEFORE_EFFORTS.search(server.model):
        body["thinking"] = {"type": "enabled", "budget_tokens": min(_THINKING[effort], most - 1)}
    elif effort is not None:
        body["thinking"] = {"type": "adaptive"}
        output["effort"] = "low" if effort == "minimal" else effort
    if model.settings.schema != "none":
        output["format"] = {"type": "json_schema", "schema": schema}
    return body | ({"output_config": output} if output else {})
