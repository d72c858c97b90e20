"""Results as rows: what is written is read back, keeps to the published schema, and a row is found by what it is of."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from builders import write_study
from hypothesis import given, settings
from hypothesis import strategies as st

import lockprobe
from lockprobe.foundation.errors import Missing
from lockprobe.report.page import results_text, write_report
from lockprobe.report.rows import Condition, Curve, Design, Estimate, Fact, NoSuchRow, Player, Progress, Results
from lockprobe.studies.options.studyfile import study

LABELS = {"truth": 0.0, "flip?p=0.4": 0.4}
AGENTS = ("human-inspired", "random")

numbers = st.none() | st.floats(-1e6, 1e6)
words = st.text(max_size=8)
estimates = st.builds(
    Estimate, quantity=st.sampled_from(["success", "loop_rate"]), agent=words, condition=words, of=words, value=numbers,
    low=numbers, high=numbers, p_value=st.none() | st.floats(0, 1), doses=st.dictionaries(words, st.floats(0, 1)),
)  # fmt: skip


def results(*rows):
    head = Results(
        lockprobe="1", study={"seed": 1}, settings_hash="0" * 32, results_hash="1" * 32,
        progress=Progress(planned=4, finished=3),
        design=Design(
            conditions=[Condition(name=name, modality="symbolic", p=p) for name, p in LABELS.items()],
            players=[Player(agent=name, modality="symbolic", subject=name == AGENTS[0]) for name in AGENTS],
        ),
    )  # fmt: skip
    return head.with_rows(rows)


def share(quantity="success", agent=AGENTS[0], condition="truth", value=0.5, **more):
    return Estimate(quantity=quantity, agent=agent, modality="symbolic", condition=condition, value=value, **more)


def played():
    return results(
        *(share("trials", agent, label, 10) for agent in AGENTS for label in LABELS),
        *(share(agent=agent, condition=label, value=0.1 + p) for agent in AGENTS for label, p in LABELS.items()),
    )


@settings(max_examples=25)
@given(st.lists(estimates, max_size=5))
def test_what_is_written_is_read_back_from_lines_without_columns_that_say_nothing(rows):
    found = results(*rows, Curve(quantity="fit", x=(0, 1), value=(0.5, None)), Fact(about="a", name="b", text="A."))
    assert Results.model_validate_json(results_text(found)) == found
    lines = [line.strip().rstrip(",") for line in results_text(results(*rows)).split("\n")]
    written = [json.loads(line) for line in lines if line.startswith('{"quantity"')]
    assert len(written) == len(rows)
    assert not any("versus" in row for row in written)


def test_a_row_is_found_by_what_it_is_of():
    found = played()
    assert found.one("success", agent="random", condition="flip?p=0.4").value == 0.5
    assert [row.agent for row in found.where("success", condition="truth")] == list(AGENTS)
    assert found.get("success", agent="nobody") is None
    assert len(found.where()) == len(found.where("trials")) + len(found.where("success"))


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"quantity": "sucess"}, "sucess: no row has all. Quantities: success"),
        ({"quantity": "success", "agent": "rndom"}, "no row has agent=rndom. agent: human-inspired, random"),
        ({"quantity": "success", "agent": "random"}, "they differ in condition. Give one of flip?p=0.4, truth"),
    ],
)
def test_a_miss_says_what_there_is(asked, said):
    with pytest.raises(NoSuchRow) as raised:
        played().one(**asked)
    assert said in str(raised.value)


def test_a_frame_has_a_column_for_each_dose_and_without_pandas_says_in_one_line_how_to_get_it(monkeypatch):
    found = results(share(doses={"flip.p": 0.4}), share("loop_rate", n=5))
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=lambda rows, columns: (rows, columns)))
    rows, columns = found.frame()
    assert [row.get("flip.p") for row in rows] == [0.4, None]
    assert [row["quantity"] for row in rows] == ["success", "loop_rate"]
    assert "flip.p" in columns
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(Missing, match="^frames need the package pandas: uv pip install pandas$"):
        found.frame()


PUBLISHED = Path(__file__).parents[2] / "docs" / "results.schema.json"


def test_the_published_schema_is_that_of_the_types():
    assert json.loads(PUBLISHED.read_text("utf-8")) == Results.model_json_schema()


def test_a_report_keeps_to_it(tmp_path):
    planned = study("flips", agent=["random", "human-inspired"], p=[0, 0.4], condition="nudge", trials=2)
    directory = write_study(tmp_path / "study", planned)
    write_report(directory)
    text = (directory / "results.json").read_bytes()
    written, found = Results.model_validate_json(text), lockprobe.results(directory)
    assert written == found
    assert written.plain() == json.loads(text)
    assert len(found.courses()) == 2
