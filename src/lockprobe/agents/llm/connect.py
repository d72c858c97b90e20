"""Opens a provider's model. Missing keys, packages and servers are reported in one line."""

from __future__ import annotations

import os
import re
from importlib.util import find_spec
from typing import Any
from urllib.parse import urlsplit

from lockprobe.agents.llm.answer_limits import guard_answers
from lockprobe.agents.llm.connections import spread_connections
from lockprobe.agents.llm.inspect_internals import PrerequisiteError
from lockprobe.agents.llm.network_settings import check_certificates, check_key, check_proxies, is_url
from lockprobe.agents.llm.openai_answers import check_answers
from lockprobe.agents.llm.openai_fast_path import use_fast_path
from lockprobe.agents.model_access import Access
from lockprobe.foundation.errors import BadValue, Missing, UserMistake, needing

with needing("hosted models", "providers"):
    from inspect_ai.model import GenerateConfig, Model, get_model

_STARTED_HERE = {
    "vllm": ("VLLM_BASE_URL", "vllm"),
    "vllm-completions": ("VLLM_BASE_URL", "vllm"),
    "sglang": ("SGLANG_BASE_URL", "sglang"),
}
"""Providers for which Inspect AI can start a server: the variable with the URL of a running one, and the package."""


def opened(name: str, access: Access, parameters: dict[str, object]) -> Model:
    """Open a model; every request sends the parameters, named as in Inspect AI's ``GenerateConfig``.

    Raises:
        Missing: If a key, a server or a provider's package is missing, or no request can carry the key.
        BadValue: If there is no such provider, or the environment names an invalid server, proxy or file of
            certificates.
    """
    _check_addresses(name)
    provider = name.partition("/")[0]
    variable, package = _STARTED_HERE.get(provider, ("", ""))
    if variable and not os.environ.get(variable) and find_spec(package) is None:
        remedy = f"export {variable}=http://HOST:PORT/v1 of a running server, or pip install {package} to start one"
        raise Missing(f"llm:{name} needs a server", remedy)
    # vLLM's client comes with the first request otherwise, and would wait and ask again behind our back
    options: dict[str, Any] = {"lazy_init": False} if package == "vllm" and os.environ.get(variable) else {}
    config = GenerateConfig(reasoning_summary="none", max_retries=access.retries)
    try:
        model = get_model(name, config=config.model_copy(update=parameters), memoize=False, **options)
    except (PrerequisiteError, ValueError) as error:
        raise mistake(name, error) from None
    client: Any = getattr(model.api, "client", None)
    if hasattr(client, "max_retries"):
        client.max_retries, client.timeout = 0, None  # so that all waiting is ours, and counted
    spread_connections(client)
    use_fast_path(client)
    check_answers(client)
    guard_answers(client)
    return model


def mistake(name: str, error: Exception) -> UserMistake:
    """Inspect AI's error for a model that cannot be opened, on one line."""
    said = " ".join(re.sub(r"\[/?[a-z ]*\]|ERROR:?", "", str(error)).split())
    if keys := re.findall(r"[A-Z][A-Z0-9_]*_(?:KEY|TOKEN|URL|ID)\b", said):
        return Missing(f"llm:{name} needs {keys[0]}", f"export {keys[0]}=… and run again")
    if package := re.search(r"pip install (\S+)|No module named '([\w.]+)'", said):
        needed = package[1] or package[2]
        return Missing(f"llm:{name} needs the package {needed}", f"pip install {needed}")
    return BadValue("language model", name, f"PROVIDER/MODEL as Inspect AI names it ({said})")


def host_of(name: str) -> str | None:
    """The host configured for a model; None for the provider's own."""
    url = next((url for variable in _variables(name) if (url := os.environ.get(variable))), "")
    try:
        return urlsplit(url).hostname
    except ValueError:
        return None


def _variables(name: str) -> tuple[str, str]:
    """The variables that can name the server of a model; the first has priority."""
    return f"{_whose(name)}_BASE_URL", "INSPECT_EVAL_MODEL_BASE_URL"


def _whose(name: str) -> str:
    """How the variables of a model's provider begin."""
    provider, service, *_ = f"{name}/".split("/")
    return (service if provider == "openai-api" else provider).upper().replace("-", "_")


def _check_addresses(name: str) -> None:
    """Refuse what the environment says of servers, keys, proxies and certificates, before a library raises an error."""
    for variable in _variables(name):
        if (url := os.environ.get(variable)) and not is_url(url, ("http", "https")):
            raise BadValue(variable, url, "a URL such as http://localhost:8080/v1")
    check_key(f"{_whose(name)}_API_KEY")
    check_proxies()
    check_certificates(name.partition("/")[0])


def config_of(model: Model) -> GenerateConfig:
    """The parameters sent with every request; some providers require a limit on the reply."""
    config = model.config
    if config.max_tokens is None:
        config = config.model_copy(
            update={"max_tokens": model.api.max_tokens_for_config(config) or model.api.max_tokens()}
        )
    return config
