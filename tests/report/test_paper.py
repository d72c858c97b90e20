"""What an article needs: the paper's exhibits by name, numbers of the study, methods without a spec, and TeX takes it."""

import json
import re
import shutil
import subprocess

import pytest
from builders import write_study
from placeholders import undrawn
from typed import in_process

from lockprobe.foundation.errors import UserMistake
from lockprobe.report.paper import methods_tex, results_tex, write_paper
from lockprobe.report.results import results
from lockprobe.studies.options.studyfile import study

EXHIBITS = {"fig3.pdf", "fig4.pdf", "fig5a.pdf", "fig5b.pdf", "table1.tex"}


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    agents = ("a_50%=cognitive:perseverant", "human-inspired", "cognitive:careful")
    planned = study("flips", agent=agents, p=(0, 0.4, 0.6), trials=6, repetitions=2)
    return write_study(tmp_path_factory.mktemp("paper") / "study", planned)


@pytest.fixture(scope="module")
def found(directory):
    return results(directory)


@pytest.fixture(scope="module")
def beside(tmp_path_factory):
    """Two kinds of false reports and two other conditions, one of them named; a baseline beside the agent."""
    kept = [f"flip?p={p}&others=kept" for p in (0.2, 0.6)]
    asked = {"agent": ("cognitive:perseverant", "round-robin"), "condition": [*kept, "drop?p=1", "late=nudge?after=3"]}
    planned = study("flips", p=(0, 0.4, 0.6), trials=8, repetitions=1, **asked)
    return results(write_study(tmp_path_factory.mktemp("beside") / "study", planned))


def test_the_command_writes_the_exhibits_beside_the_report_and_verify_says_nothing_of_it(directory):
    with undrawn():
        done = in_process("report", directory, "--paper", "--json")
        folder = directory / "paper"
        assert json.loads(done.stdout)["paper"] == str(folder)
        assert in_process("verify", directory).exit_code == 0
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert files.keys() >= EXHIBITS | {"results.tex", "methods.tex", "references.bib", "example.tex"}
    pictures = {name: content for name, content in files.items() if name.endswith(".pdf")}
    for name, picture in pictures.items():
        assert b"/FontFile2" in picture, name
        assert b"/Type3" not in picture, name
        assert b"Date" not in picture, name  # equal results give equal files
    example = files["example.tex"].decode()
    assert {*re.findall(r"\\includegraphics\[.*?\]\{(.+?)\}", example)} == {*pictures}
    assert {name.removesuffix(".pdf") for name in pictures} == {name[:-4] for name in files if name.endswith(".png")}
    assert {*re.findall(r"\\input\{(.+?)\}", example)} == {"methods", "results", "table1"}
    with pytest.raises(UserMistake):
        in_process("report", directory, directory, "--paper")


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


def rows_of(tex):
    """The rows of a table in TeX, each with the agent whose it is."""
    lines = [line.removeprefix("{}").removesuffix(r" \\") for line in tex.splitlines() if line.startswith("{}")]
    return [tuple(cell.strip() for cell in re.split(r"(?<!\\)&", line)) for line in lines]


def test_the_table_has_the_numbers_of_the_rows_and_changes_from_the_control_alone(found, beside):
    rows = rows_of(results_tex(found))
    assert [row[1] for row in rows] == ["0", "0.4", "0.6"] * 3
    assert rows[0][0] == r"a\_50\%"
    for row, cell in zip(rows, found.cells, strict=True):
        solved = cell.get("success")
        share = rf"{100 * solved.value:.0f} \% [{100 * solved.low:.0f}, {100 * solved.high:.0f}]"
        assert row[2:4] == (str(solved.n), share)
    against = {row.control for row in beside.where("success_difference", of="", versus="")}
    assert len(against) > 1
    shares, changes = {}, {}
    for agent, at, _, solved, change, _ in rows_of(results_tex(beside)):
        shares.setdefault(agent, {})[at] = float(solved.partition(" ")[0])
        changes[agent, at] = change.partition(" ")[0].replace("$-$", "-")
    assert [*shares["cognitive:perseverant"]][-2:] == ["missing reports at rate 1", "late"]
    for (agent, at), change in changes.items():
        if change:
            assert float(change) == pytest.approx(shares[agent][at] - shares[agent]["truth"], abs=1)
    assert sum(map(bool, changes.values())) >= 5


def test_a_long_table_goes_on_in_another_float(tmp_path):
    planned = study("flips", agent=("random", "round-robin"), p=[i / 20 for i in range(18)], trials=1, repetitions=1)
    said = results_tex(results(write_study(tmp_path / "study", planned)))
    assert [len(rows_of(part)) for part in said.split(r"\end{table*}")[:-1]] == [32, 4]
    assert said.count(r"\addtocounter{table}{-1}") == 1


def test_the_methods_hold_no_spec(beside):
    said = methods_tex(beside)
    assert (
        "There were 7 conditions: the truth, false reports at rates 0.4 and 0.6, false reports that stay at rates 0.2 "
        "and 0.6, missing reports at rate 1 and late (a sentence against repetition, after 3)."
    ) in said
    assert not re.search(r"\w\?\w|\w=\w|&", said)
    assert "Of these, round-robin is a baseline." in said


def test_the_figure_of_a_dose_is_among_them(tmp_path):
    planned = study("flips", agent="random", condition=[f"tremble?p={p}" for p in (0, 0.2, 0.4)], trials=2)
    with undrawn():
        written = write_paper(results(write_study(tmp_path / "study", planned)), tmp_path)
    assert (written / "series-1-success.pdf").exists()
