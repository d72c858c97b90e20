"""The lesson of 45 minutes, whose sheets, notebook and plan ask for the same commands; and the first notebook."""

import base64
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import forked
import pytest
from placeholders import undrawn
from typed import in_process

import lockprobe

ROOT = Path(__file__).parents[1]
TEACHING = ROOT / "examples" / "teaching"
NOTEBOOK = TEACHING / "lesson.ipynb"
CELLS = json.loads(NOTEBOOK.read_text("utf-8"))["cells"]
CODE = ["".join(cell["source"]) for cell in CELLS if cell["cell_type"] == "code"]
PLAN = (ROOT / "docs/teaching.md").read_text("utf-8").partition("## One lesson")[2].partition("\n## ")[0]


def sheet(name):
    return (TEACHING / f"{name}.md").read_text("utf-8")


def parts(text):
    """Number, title and text of the parts of a sheet."""
    return re.findall(r"^## (\d)\. (.*?)\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)


def joined(text):
    """Text whose lines that end with a backslash go on."""
    return re.sub(r"\\\n\s*", "", text)


def commands(text):
    """Every command in a text, without the letters that are piped into it."""
    return set(re.findall(r"(?<![\w-])lockprobe (?:play|box|run|measures) [^`|\n]+", joined(text)))


def squeezed(text):
    return " ".join(text.split())


def answers():
    """Part, command line, and what the sheet shows of its output."""
    for number, _, text in parts(sheet("answer-sheet")):
        yield from (
            (number, joined(typed).strip(), shown)
            for typed, shown in re.findall(r"^```sh\n(.*?)^```\n\n```text\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
        )


def output(line):
    """What a command line of the sheet prints; letters of ``printf`` are its input."""
    letters, _, command = line.rpartition(" | ")
    words = shlex.split(command or line)
    done = in_process(*words[1:], stdin="\n".join(shlex.split(letters)[2:]) + "\n")
    assert done.exit_code == 0, done.output
    return done.output


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """What each command of the answer sheet prints, in the folder where they were typed in order."""
    folder = tmp_path_factory.mktemp("lesson")
    with pytest.MonkeyPatch.context() as patch, undrawn():
        patch.chdir(folder)
        printed = {line: output(line) for _, line, _ in answers()}
    return folder, printed


def test_what_students_type_is_on_the_answer_sheet():
    answered = commands(sheet("answer-sheet"))
    assert commands(sheet("student-sheet")) == answered
    pictures = {"lockprobe box show chain-4 --out runs/box.png"}
    assert commands("\n".join(CODE)) - pictures == answered - {"lockprobe play --seed 30"}
    looked_at = {one for one in answered if one.startswith("lockprobe list measures")}
    assert commands(PLAN.replace("uv run ", "")) == answered - {"lockprobe play --seed 30"} - looked_at


@pytest.mark.slow
def test_each_command_prints_what_the_answer_sheet_shows(played):
    for _, line, shown in answers():
        printed = [squeezed(row) for row in played[1][line].splitlines()]
        rows = [squeezed(row) for row in shown.splitlines()]
        assert [row for row in rows if row not in printed] == [], line  # whole lines
        at = [printed.index(row) for row in rows]
        assert at == sorted(at), line


@pytest.mark.slow
def test_every_number_of_an_answer_was_printed_before(played):
    number = re.compile(r"(?<![\w.])\d+(?:\.\d+)?")
    printed, unknown = set(), []
    for part, _, text in parts(sheet("answer-sheet")):
        for owner, line, _ in answers():
            if owner == part:
                printed |= {*number.findall(line), *number.findall(played[1][line])}
        prose = re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
        unknown += [(part, found) for found in number.findall(prose) if found not in printed]
    assert unknown == []


@pytest.mark.slow
def test_the_sentences_and_figures_of_the_answer_sheet_are_in_the_reports(played):
    text = sheet("answer-sheet")
    quoted = [squeezed(one.replace("> ", "")) for one in re.findall(r"(?:^> .*\n)+", text, re.MULTILINE)]
    page = squeezed(re.sub(r"<[^>]*>", " ", (played[0] / "runs/causes/report.html").read_text("utf-8")))
    assert len(quoted) == 2
    assert all(one in page for one in quoted)
    shown = {*re.findall(r'SVG\("(runs/\w+/\S+)"', "\n".join(CODE))}
    named = {*re.findall(r"`(runs/\S+\.\w+)`", text + sheet("student-sheet"))}
    assert shown == {"runs/lesson/figures/fig4.svg"}
    assert named == shown | {"runs/causes/report.html"}
    assert all((played[0] / name).is_file() for name in named)
    assert "fig4.svg" in {*re.findall(r"`(\w+\.svg)`", PLAN)}


KERNEL = """
import sys
import nbformat
from nbclient import NotebookClient

book = nbformat.read(sys.argv[1], 4)
book.cells = book.cells[: int(sys.argv[4])]
NotebookClient(book, timeout=300, kernel_name="python3", resources={"metadata": {"path": sys.argv[2]}}).execute()
nbformat.write(book, sys.argv[3])
"""


def executed(notebook, folder, backend, cells=1000):
    """The first cells of a notebook, those with code, as a Jupyter kernel leaves them."""
    pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    done = folder / "done.ipynb"
    environment = {**os.environ, "MPLBACKEND": backend, "JUPYTER_PLATFORM_DIRS": "1"}
    subprocess.run([sys.executable, "-c", KERNEL, notebook, folder, done, str(cells)], env=environment, check=True)
    return [cell for cell in json.loads(done.read_text("utf-8"))["cells"] if cell["cell_type"] == "code"]


def pictures(cells):
    return sum("image/png" in shown.get("data", {}) for cell in cells for shown in cell["outputs"])


def printed_by(cells):
    return squeezed(" ".join("".join(shown.get("text", "")) for cell in cells for shown in cell["outputs"]))


BEFORE_THE_STUDIES = next(at for at, cell in enumerate(CELLS) if "lockprobe run" in "".join(cell["source"]))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("cells", "shown_parts", "drawn"),
    [(BEFORE_THE_STUDIES, "2", 1), (len(CELLS), "245", 2)],
    ids=["before the studies", "whole"],
)
def test_a_kernel_with_a_backend_that_is_not_there_runs_the_lesson(tmp_path, cells, shown_parts, drawn):
    """As in Colab, whose variable ``MPLBACKEND`` names a module of the kernel that other programs do not have."""
    done = executed(NOTEBOOK, tmp_path, "module://ipykernel.pylab.backend_inline", cells)
    text = printed_by(done)
    assert pictures(done) == drawn
    assert "Traceback" not in text
    assert "\x1b" not in text
    for part, line, shown in answers():
        if part in shown_parts:
            assert all(squeezed(row) in text for row in shown.splitlines()), line


@pytest.mark.slow
def test_a_kernel_runs_the_first_notebook(tmp_path):
    cells = executed(ROOT / "examples/first.ipynb", tmp_path, "module://matplotlib_inline.backend_inline")
    assert pictures(cells) == 2


FIRST = ROOT / "examples" / "first.ipynb"
FIRST_CODE = [cell for cell in json.loads(FIRST.read_text("utf-8"))["cells"] if cell["cell_type"] == "code"]

SESSION = """
import asyncio, contextlib, io, json, sys, types

class Image:
    def __init__(self, data, width):
        assert data.startswith(bytes([0x89]) + b"PNG")

display = sys.modules["IPython.display"] = types.ModuleType("IPython.display")
display.Image = Image

async def kernel(cells):
    session, printed = {}, []
    for cell in cells:
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(compile(cell, "cell", "exec"), session)
        printed.append(out.getvalue())
    return printed

print(json.dumps(asyncio.run(kernel(json.loads(sys.argv[1])))))
"""
"""A session as a kernel's: cell after cell, in a thread that runs an event loop."""


def _text(lines):
    return "".join(lines)


def shown_by(cell):
    return _text(_text(output["text"]) for output in cell["outputs"] if output["output_type"] == "stream")


def pictures_of(cell):
    found = [output["data"].get("image/png") for output in cell["outputs"] if "data" in output]
    return [base64.b64decode(_text(one)) for one in found if one]


def test_the_cells_print_what_the_notebook_shows(tmp_path):
    """Without Jupyter, whose kernel would take longer to start than the cells take to run."""
    done = forked.run([json.dumps([_text(cell["source"]) for cell in FIRST_CODE])], script=SESSION, cwd=tmp_path)
    assert done.stderr == ""
    assert json.loads(done.stdout) == [shown_by(cell) for cell in FIRST_CODE]
    assert len(lockprobe.load(tmp_path / "runs" / "first")) == 360


def test_the_notebook_is_executed_in_order_and_small():
    assert [cell["execution_count"] for cell in FIRST_CODE] == [*range(1, len(FIRST_CODE) + 1)]
    assert {output["output_type"] for cell in FIRST_CODE for output in cell["outputs"]} <= {
        "stream", "display_data", "execute_result"
    }  # fmt: skip
    drawn = [picture for cell in FIRST_CODE for picture in pictures_of(cell)]
    assert len(drawn) == 2
    assert all(picture.startswith(b"\x89PNG") for picture in drawn)
    assert FIRST.stat().st_size < 150_000
