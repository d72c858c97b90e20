"""What an article needs: every number is of the study, the files are those of print, and TeX takes them."""

import json
import re
import shutil
import subprocess
from itertools import islice

import pytest
from builders import write_study
from placeholders import undrawn
from typed import typed

from lockprobe.report.paper import paper_files, write_paper
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
