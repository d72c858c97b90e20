"""The report of a modality study: Fig. 3, Table 1, the claims of Sec. 3.1, what agents saw."""

import csv
import io
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from builders import modality_study, write_study
from captions import too_long

from lockprobe.pictures.png import to_png
from lockprobe.report import write_report


@pytest.fixture(scope="module")
def directory(tmp_path_factory, modal, picture_names):
    path = write_study(tmp_path_factory.mktemp("modal") / "study", modality_study(), modal)
    (path / "pictures").mkdir()
    rng = np.random.default_rng(0)
    for name in picture_names[:6]:
        shape = (480, 640) if name in (picture_names[3], picture_names[5]) else (480, 640, 3)
        kind = np.uint16 if len(shape) == 2 else np.uint8
        (path / "pictures" / name).write_bytes(to_png(rng.integers(0, 255, shape).astype(kind)))
    write_report(path)
    return path


def test_table_1_is_laid_out_as_in_the_paper(directory):
    rows = list(csv.reader(io.StringIO((directory / "tables" / "table1.csv").read_text())))
    assert rows[0] == [
        "Input Modality", "Average State Misinterpretation Rate per Trial", "Total State Misinterpretations",
    ]  # fmt: skip
    assert [row[0] for row in rows[1:]] == ["viewer (RGB)", "viewer (RGB-D)", "viewer (ground truth)"]
    assert [row[2] for row in rows[1:]] == ["10, in 10 of 10 trials", "30, in 10 of 10 trials", "4, in 4 of 10 trials"]
    corrected = list(csv.reader(io.StringIO((directory / "tables" / "table1-corrected.csv").read_text())))
    assert [row[0] for row in corrected[1:]] == [row[0] for row in rows[1:]]
    page = (directory / "report.html").read_text("utf-8")
    assert "30, in 10 of 10 trials" in page


def test_every_claim_of_the_section_is_measured(directory):
    content = json.loads((directory / "results.json").read_text("utf-8"))
    rows = [row for row in content["claims"] if row["place"] in ("Sec. 3.1, Fig. 3", "Table 1")]
    assert all(row["verdict"] != "not measured" for row in rows)
    by_quote = {}
    for row in rows:
        by_quote.setdefault(row["quote"][:40], {})[row["agent"]] = row
    order = by_quote["GPT o1 performs best with RGB input and "]["viewer"]
    assert order["verdict"] == "borne out"
    assert order["here"] == "mean steps 5.9 with RGB, 9.9 with RGB-D, 13.9 with ground truth"
    assert order["test"] == "log-rank test for a trend over fidelity, and the order of the mean steps"
    steps = by_quote["under RGB input, GPT o1 reaches 80% succe"[:40]]
    assert list(steps) == ["viewer"]
    assert "80 % by step 15 [" in steps["viewer"]["here"]
    assert "with ground truth" in steps["viewer"]["here"]
    assert steps["viewer"]["verdict"] == "compatible"
    outpaces = by_quote["the RGB condition reaches most success t"]["viewer"]
    assert outpaces["verdict"] == "borne out"
    assert outpaces["here"].startswith(
        "RGB reaches 10 of 10 tenths of success before RGB-D, 0 after it; RGB-D reaches 10"
    )
    faster = by_quote["requires fewer steps than GPT o1 under a"[:40]]
    assert list(faster) == ["viewer"]
    assert "with RGB, " in faster["viewer"]["here"]
    misread = [row for row in rows if row["place"] == "Table 1"]
    assert [row["agent"] for row in misread] == ["viewer (RGB)", "viewer (RGB-D)"]
    assert all("in 10 of 10 trials" in row["here"] for row in misread)


def test_the_page_says_what_modalities_do_and_shows_what_agents_saw(directory):
    content = json.loads((directory / "results.json").read_text("utf-8"))
    page = (directory / "report.html").read_text("utf-8")
    (said,) = content["modality_findings"]
    assert "10 of 10 trials (100 %) with RGB, 80 % by step 7" in said
    assert "The higher the fidelity, the later or more rarely it solves the box (log-rank" in said
    assert page.replace("<i>P</i>", "P").index(said.replace("'", "&#39;")) < page.index("Modality by modality")
    assert "was wrong at" in content["verdicts_said"]
    assert content["verdicts_said"].replace("'", "&#39;") in page
    assert page.count("data:image/png;base64,") == 6
    assert len(page) < 3_000_000
    assert "What agents saw" in page
    assert "Success and false reports" not in page
    assert "reads them without error" not in page
    assert "the report is what the picture shows: the truth, except in pictures that a flip makes false" in page


def test_rows_name_the_modality_and_runs_over_p_are_not_drawn(directory):
    content = json.loads((directory / "results.json").read_text("utf-8"))
    assert [row["label"] for row in content["conditions"]] == [
        "viewer (RGB)", "viewer (RGB-D)", "viewer (ground truth)", "human-inspired",
    ]  # fmt: skip
    assert "steps to solve, log-rank" in {row["name"] for row in content["tests"]}
    drawn = {path.name for path in (directory / "figures").iterdir()}
    assert {"fig3.png", "fig3-corrected.svg", "rationality.png"} <= drawn
    assert not {"fig4.png", "fig5b.png", "courses.png"} & drawn
    for table in ("loops", "speed", "rationality", "detectors"):
        names = {row[0] for row in csv.reader(io.StringIO((directory / "tables" / f"{table}.csv").read_text()))}
        assert {"viewer (RGB)", "viewer (ground truth)"} <= names


@pytest.mark.parametrize(
    ("layout", "beginning"),
    [
        ("fixed", "The panel was the same in every trial: of the"),
        ("shuffled", "In every trial the joints were assigned to"),
    ],
)
def test_the_report_says_whether_the_panel_was_dealt(tmp_path, layout, beginning):
    study = replace(modality_study(("viewer",), trials=2), layout=layout)
    write_report(write_study(tmp_path / "study", study, []))
    said = json.loads((tmp_path / "study" / "results.json").read_text("utf-8"))["panel_said"]
    assert said.startswith(beginning)
    page = (tmp_path / "study" / "report.html").read_text("utf-8")
    (summary,) = re.findall(r'<div class="finding">(.*?)</div>', page, re.DOTALL)
    assert f"<p>{said}</p>" in summary


def test_without_pictures_nothing_is_said_of_the_panel(tmp_path):
    write_report(write_study(tmp_path / "study", modality_study(("viewer",), ("symbolic",), trials=2), []))
    assert json.loads((tmp_path / "study" / "results.json").read_text("utf-8"))["panel_said"] == ""
    assert "the panel" not in (tmp_path / "study" / "report.html").read_text("utf-8")


def test_captions_are_short(directory):
    content = json.loads((directory / "results.json").read_text("utf-8"))
    assert too_long((directory / "report.html").read_text("utf-8"), content) == []
