"""A report is made again and compared, file by file and value by value."""

import pytest
from builders import small_study, write_study
from placeholders import undrawn

from lockprobe.report.verify.verification import verify
from lockprobe.report.write import write_report


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A study of strategies with its report."""
    directory = write_study(tmp_path_factory.mktemp("report") / "study", small_study(["random"], (0.0, 0.3), 1, 3))
    with undrawn():
        write_report(directory)
        yield directory


@pytest.fixture
def edited(written):
    """Puts another content into a file of it, for this test."""
    before = {}

    def write(name, content):
        path = written / name
        before.setdefault(path, path.read_bytes() if path.exists() else None)
        path.write_bytes(content)
        return {check.name: check for check in verify(written) if not check.holds}

    yield write
    for path, content in before.items():
        path.unlink() if content is None else path.write_bytes(content)


@pytest.mark.parametrize("name", ["figures/proof.png", "tables/proof.csv", "proof.html", "Proof.HTM"])
def test_a_file_that_the_report_does_not_have_is_named(edited, name):
    assert edited(name, b"made up")["report"].failed == (f"{name}: no file of this report",)


@pytest.mark.parametrize("name", ["notes.txt", "figures/.DS_Store"])
def test_notes_and_hidden_files_are_no_part_of_the_report(edited, name):
    assert edited(name, b"mine") == {}


def test_false_is_not_0_and_null_is_not_nothing(written, edited):
    text = (written / "results.json").read_bytes()
    assert b'"value": 0.0' in text
    failed = edited("results.json", text.replace(b'"value": 0.0', b'"value": false', 1))["results"].failed
    assert failed[0].endswith(": value False written, 0.0 computed")
    assert edited("results.json", text.replace(b'"answer"', b'"proof": null, "answer"', 1))["results"].failed == (
        "proof",
    )
    assert edited("results.json", text.replace(b'"value": 0.0', b'"value": 0', 1)) == {}


@pytest.mark.parametrize("code", ["utf-16", "utf-32-le", "utf-8-sig", "latin-1"])
def test_a_report_in_another_code_of_characters_is_named(written, edited, code):
    text = (written / "results.json").read_text("utf-8")
    assert edited("results.json", f"{text}\N{NO-BREAK SPACE}".encode(code))["results"].said.startswith(
        "results.json is "
    )
    page = (written / "report.html").read_text("utf-8")
    assert edited("report.html", page.encode(code, "replace"))["report"].failed == ("report.html",)
