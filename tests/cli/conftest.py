"""Commands as typed, in this process, and a provider on loopback that they ask."""

import pytest
from placeholders import undrawn
from provider_server import here, truthful
from typed import typed_here

from lockprobe.agents.llm.model_facts import OWN_FACTS


@pytest.fixture
def lockprobe():
    """Runs a command; gives exit status, output and errors. Its reports hold placeholders for figures."""

    def run(*words):
        with undrawn():
            done = typed_here(*words)
        return done.returncode, done.stdout, done.stderr

    return run


@pytest.fixture
def provider(monkeypatch):
    """A provider, and a function that has it answer otherwise. Reports are left out, which take seconds."""
    monkeypatch.setattr("lockprobe.report.page.write_report", lambda directory, **_: directory / "report.html")
    answers = [truthful]

    def newest(request):
        return answers[-1](request)

    with here(newest) as server:
        yield server, answers.append


@pytest.fixture
def prices(tmp_path, monkeypatch):
    """Sets what the provider takes, US dollars per million tokens."""

    def set_to(tokens_in, tokens_out):
        price = (
            f"{{ input = {tokens_in}, cached = {tokens_in}, output = {tokens_out}, date = '2026-01-02', source = 'x' }}"
        )
        (tmp_path / "models.toml").write_text(
            f"[[model]]\nmatch = ['openai-api/fake/model']\nmost_output = 100\nprice = {price}\n"
        )
        monkeypatch.setenv(OWN_FACTS, str(tmp_path / "models.toml"))

    return set_to
