"""A report is made again and compared, file by file and value by value, at the prices that it records."""

import json

import pytest
from builders import small_study, write_study
from placeholders import undrawn
from provider_server import Manner, here, truthful

from lockprobe import run_study, study
from lockprobe.agents.llm.model_facts import OWN_FACTS
from lockprobe.agents.model_access import Access
from lockprobe.report.verify.verification import verify
from lockprobe.report.write import write_report
from lockprobe.studies.running.runner import Limits

pytest.importorskip("inspect_ai")
MODEL = "llm:openai-api/fake/model"
PRICE = """[[model]]
match = ["openai-api/fake/model"]
price = {{ input = {input}, cached = 1, output = 10, date = "2026-01-02", source = "made up" }}
"""


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A study of strategies with its report."""
    directory = write_study(tmp_path_factory.mktemp("report") / "study", small_study(["random"], (0.0, 0.3), 1, 3))
    with undrawn():
        write_report(directory)
        yield directory


@pytest.fixture
def edited(written):
    """Puts another content into a file of it, for this test."""
    before = {}

    def write(name, content):
        path = written / name
        before.setdefault(path, path.read_bytes() if path.exists() else None)
        path.write_bytes(content)
        return {check.name: check for check in verify(written) if not check.holds}

    yield write
    for path, content in before.items():
        path.unlink() if content is None else path.write_bytes(content)


@pytest.mark.parametrize("name", ["figures/proof.png", "tables/proof.csv", "proof.html", "Proof.HTM"])
def test_a_file_that_the_report_does_not_have_is_named(edited, name):
    assert edited(name, b"made up")["report"].failed == (f"{name}: no file of this report",)


@pytest.mark.parametrize("name", ["notes.txt", "figures/.DS_Store"])
def test_notes_and_hidden_files_are_no_part_of_the_report(edited, name):
    assert edited(name, b"mine") == {}


def test_true_is_not_1_and_null_is_not_nothing(written, edited):
    text = (written / "results.json").read_bytes()
    assert b'"value": 1.0' in text
    failed = edited("results.json", text.replace(b'"value": 1.0', b'"value": true', 1))["results"].failed
    assert failed[0].endswith(": value True written, 1.0 computed")
    assert edited("results.json", text.replace(b'"answer"', b'"proof": null, "answer"', 1))["results"].failed == (
        "proof",
    )
    assert edited("results.json", text.replace(b'"value": 1.0', b'"value": 1', 1)) == {}


@pytest.mark.parametrize("code", ["utf-16", "utf-32-le", "utf-8-sig", "latin-1"])
def test_a_report_in_another_code_of_characters_is_named(written, edited, code):
    text = (written / "results.json").read_text("utf-8")
    assert edited("results.json", f"{text}\N{NO-BREAK SPACE}".encode(code))["results"].said.startswith(
        "results.json is "
    )
    page = (written / "report.html").read_text("utf-8")
    assert edited("report.html", page.encode(code, "replace"))["report"].failed == ("report.html",)


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
