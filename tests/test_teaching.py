"""The lesson of 45 minutes, whose sheets, notebook and plan ask for the same commands; and the first notebook."""

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
SHEETS = {name: (ROOT / f"examples/teaching/{name}-sheet.md").read_text("utf-8") for name in ("answer", "student")}
LESSON, FIRST = ROOT / "examples/teaching/lesson.ipynb", ROOT / "examples/first.ipynb"
PLAN = (ROOT / "docs/teaching.md").read_text("utf-8").partition("## One lesson")[2].partition("\n## ")[0]


def cells_of(notebook):
    """The cells with code."""
    return [cell for cell in json.loads(notebook.read_text("utf-8"))["cells"] if cell["cell_type"] == "code"]


def joined(text):
    """Text whose lines that end with a backslash go on."""
    return re.sub(r"\\\n\s*", "", text)


def commands(text):
    """Every command in a text, without the letters that are piped into it."""
    return set(re.findall(r"(?<![\w-])lockprobe (?:play|box|run|measures) [^`|\n]+", joined(text)))


def answers():
    """Command line, and what the answer sheet shows of its output."""
    shown = re.findall(r"^```sh\n(.*?)^```\n\n```text\n(.*?)^```$", SHEETS["answer"], re.DOTALL | re.MULTILINE)
    return [(joined(typed).strip(), [" ".join(row.split()) for row in text.splitlines()]) for typed, text in shown]


def test_what_students_type_is_on_the_answer_sheet():
    answered = commands(SHEETS["answer"])
    assert commands(SHEETS["student"]) == answered
    pictures = {"lockprobe box show chain-4 --out runs/box.png"}
    code = "\n".join("".join(cell["source"]) for cell in cells_of(LESSON))
    assert commands(code) - pictures == answered - {"lockprobe play --seed 30"}
    looked_at = {one for one in answered if one.startswith("lockprobe list measures")}
    assert commands(PLAN.replace("uv run ", "")) == answered - {"lockprobe play --seed 30"} - looked_at


@pytest.mark.slow
def test_each_command_prints_what_the_answer_sheet_shows_and_the_page_says_what_it_quotes(tmp_path, monkeypatch):
    """Letters of ``printf`` are a command's input."""
    monkeypatch.chdir(tmp_path)
    with undrawn():
        for line, rows in answers():
            letters, _, command = line.rpartition(" | ")
            words = shlex.split(command or line)
            done = in_process(*words[1:], stdin="\n".join(shlex.split(letters)[2:]) + "\n")
            assert done.exit_code == 0, done.output
            printed = [" ".join(row.split()) for row in done.output.splitlines()]
            assert [row for row in rows if row not in printed] == [], line  # whole lines
            at = [printed.index(row) for row in rows]
            assert at == sorted(at), line
    quoted = [one.replace("> ", "") for one in re.findall(r"(?:^> .*\n)+", SHEETS["answer"], re.MULTILINE)]
    page = " ".join(re.sub(r"<[^>]*>", " ", Path("runs/causes/report.html").read_text("utf-8")).split())
    assert len(quoted) == 2
    assert all(" ".join(one.split()) in page for one in quoted)


KERNEL = """
import sys
import nbformat
from nbclient import NotebookClient

book = nbformat.read(sys.argv[1], 4)
NotebookClient(book, timeout=300, kernel_name="python3", resources={"metadata": {"path": sys.argv[2]}}).execute()
nbformat.write(book, sys.argv[3])
"""


@pytest.mark.slow
def test_a_kernel_runs_the_lesson(tmp_path):
    """As in Colab, whose variable ``MPLBACKEND`` names a module of the kernel that other programs do not have."""
    pytest.importorskip("nbclient")
    backend = pytest.importorskip("ipykernel.pylab.backend_inline").__name__
    environment = {**os.environ, "MPLBACKEND": f"module://{backend}", "JUPYTER_PLATFORM_DIRS": "1"}
    done = tmp_path / "done.ipynb"
    subprocess.run([sys.executable, "-c", KERNEL, LESSON, tmp_path, done], env=environment, check=True)
    outputs = [shown for cell in cells_of(done) for shown in cell["outputs"]]
    assert sum(bool({"image/png", "image/svg+xml"} & {*shown.get("data", ())}) for shown in outputs) == 2
    text = " ".join("".join(shown.get("text", "")) for shown in outputs)
    assert re.findall(r"Traceback|\x1b", text) == []
    assert "flip rate 0.4: solved" in text  # by an agent of one's own


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


def test_the_cells_print_what_the_first_notebook_shows(tmp_path):
    """Without Jupyter, whose kernel would take longer to start than the cells take to run."""
    cells = cells_of(FIRST)
    done = forked.run([json.dumps(["".join(cell["source"]) for cell in cells])], script=SESSION, cwd=tmp_path)
    assert done.stderr == ""
    printed = [[text for shown in cell["outputs"] for text in shown.get("text", ())] for cell in cells]
    assert json.loads(done.stdout) == ["".join(lines) for lines in printed]
    assert len(lockprobe.load(tmp_path / "runs" / "first")) == 360
    assert [cell["execution_count"] for cell in cells] == [*range(1, len(cells) + 1)]
    assert FIRST.stat().st_size < 150_000
