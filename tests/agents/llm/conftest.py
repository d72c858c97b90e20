"""No key, server, proxy or fact of the machine's own reaches a test of models; those that tests ask have a key."""

import os
from contextlib import contextmanager

import pytest
from provider_server import ASKED, here

from lockprobe.agents.llm.model_facts import OWN_FACTS

NETWORK = ("HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY", "NO_PROXY", "SSL_CERT_DIR")


@pytest.fixture(autouse=True)
def own_environment(monkeypatch):
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL")) or name.upper() in (*NETWORK, OWN_FACTS):
            monkeypatch.delenv(name)
    for provider in ASKED:
        monkeypatch.setenv(f"{provider}_API_KEY", "sk-private-0123456789")


@pytest.fixture
def served(monkeypatch):
    """``with served(answer) as server``: a server that all providers of tests are asked at."""

    @contextmanager
    def serving(answer=None):
        with here(answer) as server:
            for provider in ASKED:
                monkeypatch.setenv(f"{provider}_BASE_URL", server.url)
            yield server

    return serving
