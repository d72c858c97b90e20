"""The report of a modality study: what stands on its page, what agents saw, and how the panel was dealt."""

from html import unescape

import numpy as np
import pytest
from builders import modality_study, write_study
from captions import too_long

from lockprobe.report.claims.paper import CLAIMS
from lockprobe.report.pages import tables_of
from lockprobe.report.rows import Results
from lockprobe.report.write import write_report
from lockprobe.trial.pictures.png import to_png


def reported(path):
    """The results and the page of a report."""
    page = write_report(path).read_text("utf-8")
    return Results.model_validate_json((path / "results.json").read_bytes()), page


@pytest.fixture(scope="module")
def directory(tmp_path_factory, modal, picture_names):
    """A study with its pictures."""
    path = write_study(tmp_path_factory.mktemp("modal") / "study", modality_study(), modal)
    (path / "pictures").mkdir()
    rng = np.random.default_rng(0)
    for name in picture_names[:6]:
        shape = (480, 640) if name in (picture_names[3], picture_names[5]) else (480, 640, 3)
        kind = np.uint16 if len(shape) == 2 else np.uint8
        (path / "pictures" / name).write_bytes(to_png(rng.integers(0, 255, shape).astype(kind)))
    return path


@pytest.fixture(scope="module")
def report(directory):
    return reported(directory)


def test_the_page_says_what_modalities_do_and_shows_what_agents_saw(report):
    found, page = report
    text = unescape(page.replace("<i>P</i>", "P"))
    assert found.answer in text
    assert found.answer.startswith("The higher the fidelity of what viewer sees, the later or more rarely it solves")
    assert page.count("data:image/png;base64,") == 6
    assert len(page) < 3_000_000
    assert "What agents saw" in page
    assert "Success and false reports" not in page
    assert "reads them without error" not in page
    assert "the report is what the picture shows: the truth, except in pictures that a flip makes false" in page


def test_every_claim_of_the_section_is_measured(report):
    found, _ = report
    here = [claim.name for claim in CLAIMS if claim.place in ("Sec. 3.1, Fig. 3", "Table 1")]
    assert len(here) > 5
    assert {*here} <= {row.of for row in found.where("claim")}
    misread = [found.said("claims", name) for name in here if name.startswith("misinterpretation, ")]
    assert misread
    assert all("in 10 of 10 trials" in said for (said,) in misread)


def test_rows_name_the_modality_and_runs_over_p_are_not_drawn(directory, report):
    found, _ = report
    labels = ["viewer (RGB)", "viewer (RGB-D)", "viewer (positions and outcomes in words)", "human-inspired"]
    assert [cell.label for cell in found.cells] == [found.label(c.agent, c.modality) for c in found.cells] == labels
    drawn = {path.name for path in (directory / "figures").iterdir()}
    assert {"fig3.png", "fig3-corrected.svg"} <= drawn
    assert not {"fig4.png", "fig5b.png"} & drawn
    tables = tables_of(found)
    for name in ("loops", "speed", "optimal-actions"):
        assert {"viewer (RGB)", "viewer (positions and outcomes in words)"} <= {row[0] for row in tables[name]}, name


def test_captions_are_short(report):
    found, page = report
    assert too_long(page, [one.text for one in found.findings]) == []
