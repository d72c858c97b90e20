"""What an article needs: every number is of the study, the files are those of print, and TeX takes them."""

import json
import re
import shutil
import subprocess
from itertools import islice
from types import SimpleNamespace as Some

import pytest
from builders import write_study
from placeholders import undrawn
from typed import typed

from lockprobe.report.paper import paper_files, write_paper
from lockprobe.report.paper_table import table_tex
from lockprobe.report.results import results
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.runner import run_study


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    path = tmp_path_factory.mktemp("paper") / "study"
    run_study(
        study("flips", agent=("a_50%=cognitive:perseverant", "human-inspired"), p=(0, 0.6), trials=30, repetitions=1),
        path,
    )
    return path


@pytest.fixture(scope="module")
def found(directory):
    return results(directory)


def test_fonts_are_in_the_pictures_and_equal_results_give_equal_files(found):
    first, again = dict(paper_files(found)), dict(islice(paper_files(found), 6))
    assert first == first | again
    pictures = {name: content for name, content in first.items() if name.endswith(".pdf") and content}
    assert {
        "paper.pdf",
        "figure-column.pdf",
        "figure-wide.pdf",
        "figures/fig4.pdf",
        "figures/box.pdf",
    } <= pictures.keys()
    for name, picture in pictures.items():
        assert b"/FontFile2" in picture, name
        assert b"/Type3" not in picture, name
    assert len(re.findall(rb"/Type /Page\b", pictures["paper.pdf"])) == 2
    sizes = re.findall(rb"/MediaBox \[ 0 0 ([\d.]+) ", pictures["paper.pdf"])
    assert [round(float(one) / 72, 1) for one in sizes] == [3.5, 6.9]  # inches


@pytest.fixture
def placeholders():
    """Figures of the page take seconds, and none is looked at."""
    with undrawn():
        yield


@pytest.mark.usefixtures("placeholders")
def test_the_command_writes_it_beside_the_report_and_verify_says_nothing_of_it(directory):
    done = typed("report", directory, "--paper", "--json")
    assert json.loads(done.stdout)["paper"] == str(directory / "paper")
    assert f"Paper: {directory / 'paper'}/paper.pdf" in typed("report", directory, "--paper").stdout
    assert {"paper.pdf", "paper.tex", "methods.tex", "references.bib", "example.tex"} <= {
        path.name for path in (directory / "paper").iterdir()
    }
    assert typed("verify", directory).returncode == 0
    refused = typed("report", directory, "--paper", "--watch")
    assert (refused.returncode, refused.stderr.count("\n")) == (2, 1)


def test_nothing_is_drawn_before_a_trial_has_ended(tmp_path):
    found = results(
        write_study(tmp_path / "empty", study("flips", agent="random", p=(0,), trials=1, repetitions=1), [])
    )
    files = dict(paper_files(found))
    assert "paper.pdf" not in files
    assert "0 of 1 planned trials" in files["methods.tex"]


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="TeX is not installed")
def test_a_real_tex_compiles_it(found, tmp_path):
    folder = write_paper(found, tmp_path)
    for program in ("pdflatex", "bibtex", "pdflatex", "pdflatex"):
        options = ["-interaction=nonstopmode", "-halt-on-error"] if program == "pdflatex" else []
        done = subprocess.run([program, *options, "example"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout
    assert "undefined" not in done.stdout
    assert "Overfull" not in done.stdout
    assert (folder / "example.pdf").stat().st_size > 10_000


def test_the_table_has_six_columns_and_the_numbers_of_the_rows(found):
    lines = table_tex(found).splitlines()
    (head,) = [line for line in lines if line.startswith("agent")]
    assert head.count("&") == 5  # two columns under one head have no sign between them
    rows = [[cell.strip() for cell in line.split("&")] for line in lines if line.startswith("{}")]
    assert [row[1] for row in rows] == ["0", "0.6", "0", "0.6"]
    for row, (agent, condition) in zip(
        rows, [(agent, c) for agent in ("a_50%", "human-inspired") for c in ("truth", "flip?p=0.6")], strict=True
    ):
        solved = found.one("success", agent=agent, condition=condition)
        assert row[2:5] == [
            str(solved.n),
            f"{100 * solved.value:.0f}",
            f"$[{100 * solved.low:.0f}, {100 * solved.high:.0f}]$",
        ]
        if condition != "truth":
            change = found.one("success_difference", agent=agent, condition=condition, control="truth")
            assert row[5] == f"${100 * change.value:+.0f}$"
    assert r"a\_50\%" in rows[0][0]


def test_every_change_of_the_table_is_from_the_control_whatever_else_is_compared(tmp_path):
    conditions = ["flip?p=0.6&others=kept", "drop?p=1"]
    planned = study("flips", agent=("human-inspired", "round-robin"), p=(0, 0.6), condition=conditions, trials=8)
    found = results(write_study(tmp_path / "study", planned))
    against = {row.control for row in found.where("success_difference", agent="human-inspired", of="", versus="")}
    assert len(against) > 1
    shares = {}
    for line in table_tex(found).splitlines():
        if not line.startswith("{}"):
            continue
        agent, at, _, solved, _, change, *_ = map(str.strip, re.split(r"(?<!\\)&", line.removeprefix("{}")))
        shares[agent or next(reversed(shares))[0], at] = float(solved)
        agent, _ = next(reversed(shares))
        if change:
            truth = next(share for (of, _), share in shares.items() if of == agent)
            assert float(change.strip("$")) == pytest.approx(float(solved) - truth, abs=1)
    assert len(shares) == 8


def of_many(agents):
    """Results with so many conditions of each agent, all of them solved in 3 of 10 trials."""
    share = Some(value=0.3, n=10, low=0.1, high=0.6)
    cells = [
        Some(agent=agent, label=agent, condition=f"c{i}", p=None, modality="", get=lambda quantity: share)
        for agent, conditions in agents.items()
        for i in range(conditions)
    ]
    return Some(beside_flips=True, cells=cells, against_control=list, design=Some(conditions=()))


@pytest.mark.parametrize(
    ("agents", "parts"),
    [
        ({"a": 33}, [33]),
        ({"a": 34}, [33, 1]),
        ({"a": 20, "b": 12}, [32]),
        ({"a": 20, "b": 13}, [20, 13]),
        ({"a": 70, "b": 2}, [33, 33, 6]),
        (dict.fromkeys("abcdefghijklmnopqrstuvwxyz", 1), [22, 4]),
    ],
)
def test_a_long_table_goes_on_on_the_next_page(agents, parts):
    said = table_tex(of_many(agents))
    assert [one.count("{}") for one in said.split(r"\end{table*}")[:-1]] == parts
    rows = [line.split(" & ")[:2] for line in said.splitlines() if line.startswith("{}")]
    assert [at for _, at in rows] == [f"c{i}" for many in agents.values() for i in range(many)]
    assert said.count("(continued)") == said.count(r"\addtocounter{table}{-1}") == len(parts) - 1
    starts = [one[one.index("{}") :].split(" & ")[0] for one in said.split(r"\midrule")[1:]]
    assert all(start != "{}" for start in starts)  # every part begins with the name of an agent
