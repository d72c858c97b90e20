"""A report is made again at the prices that it records, so that it holds on every machine; other prices are named."""

import json

import pytest
from provider_server import Manner, here, truthful

from lockprobe import run_study, study
from lockprobe.agents.llm.model_facts import OWN_FACTS
from lockprobe.agents.model_access import Access
from lockprobe.report import write_report
from lockprobe.report.verification import verify
from lockprobe.studies.runner import Limits

pytest.importorskip("inspect_ai")
MODEL = "llm:openai-api/fake/model"
PRICE = """[[model]]
match = ["openai-api/fake/model"]
price = {{ input = {input}, cached = 1, output = 10, date = "2026-01-02", source = "made up" }}
"""


@pytest.fixture
def prices(tmp_path, monkeypatch):
    """Sets what is known of the model's prices; nothing where no price is given."""

    def known(price=None):
        monkeypatch.delenv(OWN_FACTS, raising=False)
        if price is not None:
            path = tmp_path / f"prices-{price}.toml"
            path.write_text(PRICE.format(input=price), "utf-8")
            monkeypatch.setenv(OWN_FACTS, str(path))

    return known


@pytest.fixture
def directory(tmp_path, monkeypatch, prices):
    """A study of a hosted model with its report, both made where a price is known."""
    prices(3)
    monkeypatch.setenv("FAKE_API_KEY", "sk-private-0123456789")
    planned = study("flips", agent=[MODEL, "random"], p=[0, 0.4], trials=2, repetitions=1, max_steps=6)
    with here(truthful, Manner()) as server:
        monkeypatch.setenv("FAKE_BASE_URL", server.url)
        run_study(planned, tmp_path / "out", limits=Limits(access=Access(connections=2)))
    write_report(tmp_path / "out")
    assert next(dollars(results(tmp_path / "out")))["value"] > 0
    return tmp_path / "out"


def results(directory):
    return json.loads((directory / "results.json").read_text("utf-8"))


def dollars(found):
    """The rows on what the model cost."""
    return (row for row in found["rows"] if (row["quantity"], row["agent"]) == ("cost", MODEL))


def checked(directory):
    """What is said of the results, and the checks that fail."""
    checks = verify(directory)
    said = next(check.said for check in checks if check.name == "results")
    return said, [check.name for check in checks if not check.holds]


@pytest.mark.parametrize(("price", "here"), [(None, "none is known here"), (7, "others are known here")])
def test_a_report_holds_where_other_prices_are_known_and_that_is_said(directory, prices, price, here):
    assert checked(directory) == ("results.json is what the records give", [])
    prices(price)
    said, failed = checked(directory)
    assert failed == []
    assert said.endswith(f"{MODEL} is counted at the prices on record, of 2026-01-02 (made up), and {here}")


def test_edited_dollars_are_found_where_no_price_is_known(directory, prices):
    prices()
    found = results(directory)
    for row in dollars(found):
        row["value"] /= 2
    (directory / "results.json").write_text(json.dumps(found), "utf-8")
    assert checked(directory)[1] == ["results"]


@pytest.mark.parametrize("edited", [{"input": 0.001}, None, {"input": "x"}])
def test_an_edited_price_is_found_by_the_dollars_and_named(directory, edited):
    found = results(directory)
    price = [one for one in found["facts"] if one["about"] == f"price of {MODEL}"]
    assert price
    for one in price:
        if edited is None:
            found["facts"].remove(one)
        elif one["name"] in edited:
            one["text"] = str(edited[one["name"]])
    (directory / "results.json").write_text(json.dumps(found), "utf-8")
    said, failed = checked(directory)
    assert "results" in failed
    assert edited == {"input": "x"} or "others are known here" in said
