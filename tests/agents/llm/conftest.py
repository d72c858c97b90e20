"""No key, server, proxy or fact of the machine's own reaches a test of models; those that tests ask have a key."""

import os

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

    class Served:
        def __init__(self, answer=None, manner=None):
            self._server = here(answer, manner, keep=True)

        def __enter__(self):
            server = self._server.__enter__()
            for provider in ASKED:
                monkeypatch.setenv(f"{provider}_BASE_URL", server.url)
            return server

        def __exit__(self, *error):
            return self._server.__exit__(*error)

    return Served
