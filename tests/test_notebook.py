"""The notebook in ``examples``: its cells run in one session, and print what the file shows."""

import base64
import json
import re
from pathlib import Path

import forked

import lockprobe

ROOT = Path(__file__).parents[1]
NOTEBOOK = ROOT / "examples" / "first.ipynb"
CELLS = json.loads(NOTEBOOK.read_text("utf-8"))["cells"]
CODE = [cell for cell in CELLS if cell["cell_type"] == "code"]

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


def text(lines):
    return "".join(lines)


def shown(cell):
    return text(text(output["text"]) for output in cell["outputs"] if output["output_type"] == "stream")


def pictures(cell):
    found = [output["data"].get("image/png") for output in cell["outputs"] if "data" in output]
    return [base64.b64decode(text(one)) for one in found if one]


def test_the_cells_print_what_the_notebook_shows(tmp_path):
    """Without Jupyter, whose kernel would take longer to start than the cells take to run."""
    done = forked.run([json.dumps([text(cell["source"]) for cell in CODE])], script=SESSION, cwd=tmp_path)
    assert done.stderr == ""
    assert json.loads(done.stdout) == [shown(cell) for cell in CODE]
    assert len(lockprobe.load(tmp_path / "runs" / "first")) == 360


def test_the_notebook_is_executed_in_order_and_small():
    assert [cell["execution_count"] for cell in CODE] == [*range(1, len(CODE) + 1)]
    assert {output["output_type"] for cell in CODE for output in cell["outputs"]} <= {
        "stream", "display_data", "execute_result"
    }  # fmt: skip
    drawn = [picture for cell in CODE for picture in pictures(cell)]
    assert len(drawn) == 2
    assert all(picture.startswith(b"\x89PNG") for picture in drawn)
    assert NOTEBOOK.stat().st_size < 150_000


def test_the_notebook_shows_a_false_report_and_leads_on():
    assert any("  <-" in shown(cell) for cell in CODE)
    assert any("0.8008" in shown(cell) for cell in CODE)
    links = re.findall(
        r"\]\(([^)]+)\)", text(text(cell["source"]) for cell in CELLS if cell["cell_type"] == "markdown")
    )
    assert len(links) >= 3
    assert all((NOTEBOOK.parent / link).is_file() for link in links)
