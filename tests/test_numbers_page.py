"""What docs/numbers.md prints on the way of one number is what its commands print."""

import re
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
from typer.testing import CliRunner

from lockprobe.boxes.families import box
from lockprobe.boxes.solve import random_no_repeat_success
from lockprobe.cli import build
from lockprobe.foundation.formatting import percent

PAGE = (Path(__file__).parents[1] / "docs" / "numbers.md").read_text("utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def typed(line):
    _, name, *words = line.replace("'", "").split()
    done = CliRunner().invoke(build([name]), [name, *words])
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """What each block of the page prints, in order, and what its text blocks show."""
    patch = pytest.MonkeyPatch()
    where = tmp_path_factory.mktemp("numbers")
    patch.chdir(where)
    session, out, shown = {}, [], []
    for kind, block in BLOCKS:
        if kind == "text":
            shown.append(block)
        elif kind == "sh":
            out.append(typed(block.strip()))
        else:
            with redirect_stdout(StringIO()) as said:
                exec(compile(block, "numbers.md", "exec"), session)
            out.append(said.getvalue())
    yield where, out, shown
    patch.undo()


def test_every_block_prints_what_the_page_shows(printed):
    _, (_, replayed, _, *prints), (trial, *values, _, _) = printed
    assert [line.rstrip() for line in replayed.splitlines()] == trial.splitlines()
    assert prints == values


def test_the_table_and_the_answer_are_those_of_the_page(printed):
    where, (ran, *_), shown = printed
    head, row = (line.removesuffix("…") for line in shown[-2].splitlines())
    first, *lines = (where / "one/tables/conditions.csv").read_text("utf-8").splitlines()
    assert first.startswith(head)
    assert any(line.startswith(row) for line in lines)
    (answer,) = re.findall(r"both rows: \"(.*?)\"", " ".join(PAGE.split()))
    assert answer in " ".join(
        (where / "one/report.html").read_text("utf-8").replace("<code>", "").replace("</code>", "").split()
    )
    assert answer in " ".join(ran.split())
    (cell,) = re.findall(r"shows the row as `(.*?)`", " ".join(PAGE.split()))
    assert f">{cell}<" in (where / "one/report.html").read_text("utf-8")


def test_verify_says_what_the_page_says(printed):
    where, _, shown = printed
    found = typed(f"lockprobe verify {where / 'one'}").splitlines()
    assert all(line in found for line in shown[-1].splitlines())


def test_the_chance_level_is_that_of_the_box():
    (said,) = re.findall(r"never repeats a joint at once solves (\d+ %)", " ".join(PAGE.split()))
    assert said == percent(random_no_repeat_success(box("chain-4")))
