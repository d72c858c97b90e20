"""Commands as typed, in this process, and a provider on loopback that they ask."""

import sys

import pytest
from placeholders import undrawn
from provider_server import here, truthful

from lockprobe.agents.llm.model_facts import OWN_FACTS
from lockprobe.cli import main


@pytest.fixture
def lockprobe(monkeypatch, capsys):
    """Runs a command; gives exit status, output and errors. Its reports hold placeholders for figures."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["lockprobe", *map(str, arguments)])
        with undrawn(), pytest.raises(SystemExit) as ended:
            main()
        captured = capsys.readouterr()
        return ended.value.code or 0, captured.out, captured.err

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
