"""``lockprobe list models``: what is known of a hosted model, what it would be sent, and what it reads."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from lockprobe.agents.llm.model_facts import OWN_FACTS, price_of
from lockprobe.cli.list_ import app
from lockprobe.foundation.errors import BadValue
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.prompts import in_words


@pytest.fixture(autouse=True)
def nothing_of_ones_own(monkeypatch):
    monkeypatch.delenv(OWN_FACTS, raising=False)


def show(*words):
    done = CliRunner().invoke(app, ["models", *words])
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.stdout


def test_what_is_sent_stands_beside_what_is_known_and_the_price_has_its_date():
    lines = [line.split(maxsplit=2) for line in show("llm:openai/gpt-4o?temperature=0.5").splitlines()]
    assert ["sent", "temperature", "0.5"] in lines
    assert ["known", "most_output", "16384"] in lines
    assert ["known", "efforts", "none"] in lines
    (price,) = (value for _, what, value in lines[1:] if what == "price")
    assert price.startswith("input 2.5, cached 1.25, output 10.0, stored 2.5, date genai-prices ")


def test_of_an_unknown_model_it_says_that_nothing_is_known():
    said = show("vllm/my-own-model")
    assert said.startswith("vllm/my-own-model: no facts are known")
    assert "known  " not in said


def test_the_prompts_of_the_three_modalities_stand_in_the_docs_as_they_are_printed():
    page = (Path(__file__).parents[2] / "docs" / "as-paper.md").read_text("utf-8")
    printed = in_words(study("modalities", as_paper=True))
    assert page.partition("```text\n")[2].partition("```")[0] == printed
    assert printed.count("  all:") >= 4
    assert max(map(len, printed.splitlines())) < 120


def test_without_a_name_it_lists_the_embedded_model_and_prices():
    lines = show().splitlines()
    assert lines[0].startswith("llm:local  ")
    assert any(line.startswith("llm:openai/gpt-4o ") and "2.5 in, 10 out" in line for line in lines)


def test_json_has_every_fact():
    (line,) = show("openai/o1?effort=low", "--json").splitlines()
    found = json.loads(line)
    assert (found["model"], found["known"], found["sent"]["effort"]) == ("openai/o1", True, "low")
    assert found["facts"]["price"]["output"] == price_of("openai/o1").output


@pytest.mark.parametrize("spec", ["gpt-4o", "llm:local", "openai/"])
def test_what_names_no_model_of_a_provider_is_refused(spec):
    with pytest.raises(
        BadValue,
        match=f"^language model: got '{spec.removeprefix('llm:')}', expected PROVIDER/MODEL, for example",
    ):
        show(spec)


def test_a_setting_that_the_model_refuses_is_one_line():
    with pytest.raises(
        BadValue, match="^temperature: got 1.0, expected no temperature with llm:openai/o1, which fixes it$"
    ):
        show("openai/o1?temperature=1")
