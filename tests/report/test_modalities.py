"""The report of a modality study: Fig. 3, Table 1 and the claims by modality, what agents saw, a robot's verdicts."""

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest
from builders import SOLUTION, make_trial, modality_study, write_study

from lockprobe.analysis.summary import summarise
from lockprobe.pictures.png import to_png
from lockprobe.report import results, write_report
from lockprobe.report.claims import claim_rows
from lockprobe.report.compared import same_step
from lockprobe.report.seen import embedded, seen

NAMES = [f"{i:020x}.png" for i in range(8)]
PICTURES = [
    {"rgb": NAMES[0]},
    {"rgb": NAMES[1]},
], [
    {"rgb": NAMES[0], "depth": NAMES[2], "depth16": NAMES[3]},
    {"rgb": NAMES[1], "depth": NAMES[4], "depth16": NAMES[5]},
]  # fmt: skip


def trials_of(modality, waits, agent="viewer", **more):
    """Trials that solve the box after so many blocked steps at the target, the first few of them misread."""
    return [
        make_trial(
            [0] * wait + list(SOLUTION), agent=agent, modality=modality, study="modalities", trial=i,
            claims=[None, *(["moved"] * min(wait, misread)), *["blocked"] * max(0, wait - misread), *["moved"] * 4],
            verdicts=["moved"] * (1 + (i == 1)) + ["blocked"] * wait, **more,
        )
        for i, (wait, misread) in enumerate(waits, 1)
    ]  # fmt: skip


def played():
    soon = [(1 + i % 3, 1) for i in range(10)]
    later = [(5 + i % 3, 3) for i in range(10)]
    latest = [(9 + i % 3, i < 4) for i in range(10)]
    return [
        *trials_of("rgb", soon, pictures=PICTURES[0]),
        *trials_of("rgbd", later, pictures=PICTURES[1]),
        *trials_of("symbolic", latest),
        *trials_of("symbolic", [(2, 0)] * 10, agent="human-inspired"),
    ]


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    path = write_study(tmp_path_factory.mktemp("modal") / "study", modality_study(), played())
    (path / "pictures").mkdir()
    rng = np.random.default_rng(0)
    for name in NAMES[:6]:
        shape = (480, 640) if name in (NAMES[3], NAMES[5]) else (480, 640, 3)
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
    assert [row[2] for row in rows[1:]] == ["10**", "30**", "4*"]
    corrected = list(csv.reader(io.StringIO((directory / "tables" / "table1-corrected.csv").read_text())))
    assert [row[0] for row in corrected[1:]] == [row[0] for row in rows[1:]]
    page = (directory / "report.html").read_text("utf-8")
    assert "*: occurred in 4 out of 10 trials" in page
    assert "**: occurred in 10 out of 10 trials" in page


def test_every_claim_of_the_section_is_measured(directory):
    rows = [row for row in results(directory)["claims"] if row["place"] in ("Sec. 3.1, Fig. 3", "Table 1")]
    assert all(row["verdict"] != "not measured" for row in rows)
    by_quote = {}
    for row in rows:
        by_quote.setdefault(row["quote"][:40], {})[row["agent"]] = row
    order = by_quote["GPT o1 performs best with RGB input and "]["viewer"]
    assert order["verdict"] == "borne out"
    assert order["here"] == "mean steps 5.9 with RGB, 9.9 with RGB-D, 13.9 with ground truth"
    assert order["test"] == "log-rank for a trend over fidelity"
    steps = by_quote["under RGB input, GPT o1 reaches 80% succe"[:40]]
    assert list(steps) == ["viewer (RGB)", "viewer (ground truth)"]
    assert steps["viewer (ground truth)"]["here"].startswith("80 % by step 15 [")
    assert steps["viewer (ground truth)"]["verdict"] == "compatible"
    faster = by_quote["requires fewer steps than GPT o1 under a"[:40]]
    assert faster["viewer (ground truth)"]["verdict"] == "borne out"
    assert set(faster) == {"viewer (RGB)", "viewer (RGB-D)", "viewer (ground truth)"}
    misread = [row for row in rows if row["place"] == "Table 1"]
    assert [row["agent"] for row in misread] == ["viewer (RGB)", "viewer (RGB-D)"]
    assert all("in 10 of 10 trials" in row["here"] for row in misread)


def test_a_step_outside_of_its_interval_is_not_compatible():
    symbolic = summarise(played()).agents[2].conditions[0]
    assert same_step(symbolic, 15)[1] == "compatible"
    assert same_step(symbolic, 9)[1] == "not compatible"


def test_the_opposite_order_is_not_borne_out():
    turned = {"rgb": "symbolic", "symbolic": "rgb", "rgbd": "rgbd"}
    trials = [t if t.agent != "viewer" else replace(t, modality=turned[t.modality]) for t in played()]
    (row,) = [row for row in claim_rows(summarise(trials)) if row.claim.measure == "modality-order"]
    assert row.verdict == "not borne out"
    assert row.p_value < 0.05


def test_a_study_of_one_modality_says_nothing_of_modalities():
    rows = claim_rows(summarise([trial for trial in played() if trial.modality == "symbolic"]))
    for row in rows:
        if row.claim.measure.startswith(("modalit", "reference-faster")) or row.claim.modality != "symbolic":
            assert row.verdict == "not measured"


def test_the_page_says_what_modalities_do_and_shows_what_agents_saw(directory):
    content = json.loads((directory / "results.json").read_text("utf-8"))
    page = (directory / "report.html").read_text("utf-8")
    (said,) = content["modality_findings"]
    assert "10 of 10 trials (100 %) with RGB, 80 % by step 7" in said
    assert "The higher the fidelity, the later or more rarely it solves the box (log-rank" in said
    assert page.index(said.replace("'", "&#39;")) < page.index("Modality by modality")
    assert "was wrong at" in content["verdicts_said"]
    assert content["verdicts_said"].replace("'", "&#39;") in page
    assert page.count("data:image/png;base64,") == 6
    assert len(page) < 3_000_000
    assert "What agents saw" in page
    assert "Success and false reports" not in page
    assert "reads them without error" not in page
    assert "A picture shows the truth" in page


def test_no_picture_is_shown_that_only_the_record_needs(directory):
    rows = seen(played())
    assert [row["modality"] for row in rows] == ["rgb", "rgbd"]
    assert [moment["files"] for moment in rows[1]["moments"]] == [[NAMES[0], NAMES[2]], [NAMES[1], NAMES[4]]]
    assert rows[0]["moments"][1]["when"] == "after step 1: revolute-left did not move"


def test_the_first_move_is_shown_too():
    (row,) = seen([make_trial([0, 3], budget=2, modality="rgb", pictures=[{"rgb": name} for name in NAMES[:3]])])
    assert [moment["when"] for moment in row["moments"]] == [
        "before the first step", "after step 1: revolute-left did not move", "after step 2: revolute-right moved",
    ]  # fmt: skip
    (row,) = seen([make_trial([3], budget=1, modality="rgb", pictures=[{"rgb": name} for name in NAMES[:2]])])
    assert len(row["moments"]) == 2


def test_pictures_that_are_lost_or_lie_elsewhere_are_left_out(tmp_path):
    (tmp_path / "pictures").mkdir()
    (tmp_path / "secret.png").write_bytes(to_png(np.zeros((8, 8), np.uint8)))
    (tmp_path / "pictures" / NAMES[1]).write_bytes(b"torn")
    rows = [{"moments": [{"files": ["../secret.png", NAMES[0], NAMES[1]]}]}]
    assert embedded(tmp_path, rows) == {}


def test_pictures_are_made_small(tmp_path):
    (tmp_path / "pictures").mkdir()
    (tmp_path / "pictures" / NAMES[0]).write_bytes(to_png(np.full((301, 700, 3), 9, np.uint8)))
    ((name, data),) = embedded(tmp_path, [{"moments": [{"files": [NAMES[0]]}]}]).items()
    assert name == NAMES[0]
    import base64

    from lockprobe.pictures.png import from_png

    small = from_png(base64.b64decode(data.partition(",")[2]))
    assert small.shape == (100, 233, 3)
    assert (small == 9).all()


def test_rows_name_the_modality_and_runs_over_p_are_not_drawn(directory):
    content = results(directory)
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
