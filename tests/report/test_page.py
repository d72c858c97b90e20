"""A report is whole, the same from the same records, and safe to open."""

import csv
import io
import re
from base64 import b64encode
from hashlib import sha256
from html.parser import HTMLParser

import pytest
from builders import SOLUTION, make_trial, play_study, small_study, write_study
from reported import found_in

from lockprobe.report.format import as_csv
from lockprobe.report.page import Page, image, write_report
from lockprobe.report.questions import all_sections
from lockprobe.report.rendering import rendered
from lockprobe.report.rows import Estimate
from lockprobe.report.section import Table
from lockprobe.report.verify import verify

ATTACK = "<script>alert('x')</script><img src=https://evil.example/x onerror=alert(1)>"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return found_in(tmp_path_factory.mktemp("page"), small_study())


class Parsed(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.loads = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.loads += [value for name, value in attrs if name in ("src", "href", "srcset", "data", "action")]


def test_the_page_loads_nothing_and_runs_one_program_of_ours(found):
    picture = image(b"<svg />")
    text = Page(found=found, drawn={figure.name: picture for of in all_sections() for figure in of.figures}).text()
    page = Parsed(text)
    assert all(load.startswith(("data:image/", "#")) for load in page.loads)
    assert not {"link", "iframe", "object"} & set(page.tags)
    assert page.tags.count("script") == 2  # the trials as JSON, and the program
    assert set(re.findall(r"https?://[\w./]*", text)) <= {"http://www.w3.org/2000/svg"}
    policy = re.search(r'Security-Policy" content="([^"]*)"', text)[1]
    assert "default-src 'none'" in policy
    hashes = re.findall(r"script-src '(sha256-[^']*)'", policy)
    programs = re.findall(r"(?s)<script>(.*?)</script>", text)
    assert hashes == [f"sha256-{b64encode(sha256(one.encode()).digest()).decode()}" for one in programs]


def test_what_models_say_is_escaped(tmp_path):
    said = {"agent": "llm:evil/" + "<b>x</b>", "hypothesis": ATTACK, "facts": {"model": ATTACK}}
    trials = [make_trial(SOLUTION, p=p, trial=i, **said) for p in (0.0, 0.3) for i in (1, 2)]
    trials += [make_trial([0, 1, 2] * 4, budget=12, p=0.0, trial=3, claims=[None, "moved"], **said)]
    found = found_in(tmp_path, small_study([said["agent"]], (0.0, 0.3), 1, 3), trials)
    text = Page(found=found).text()
    page = Parsed(text)
    assert page.tags.count("script") == 2
    assert not [load for load in page.loads if "evil" in load]
    assert "img" not in page.tags
    assert "&lt;script&gt;" in text
    assert "<b>x</b>" not in text


def test_no_name_hides_or_reorders_what_stands_beside_it_and_order_of_records_changes_nothing(tmp_path):
    name = "llm:evil/\u202ea\u2066b\nc\x1bd"
    trials = [make_trial(SOLUTION, p=p, hypothesis=name, agent="llm:a/b", facts={"model": name}) for p in (0.0, 0.3)]
    planned = small_study(["llm:a/b"], (0.0, 0.3), 1, 1)
    found, again = (found_in(tmp_path / of, planned, made) for of, made in (("a", trials), ("b", trials[::-1])))
    assert found == again
    text = Page(found=found).text()
    assert text == Page(found=again).text()
    assert "llm:evil/?a?b c?d" in text
    assert all(line.isprintable() for line in text.split("\n"))


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    directory = write_study(tmp_path_factory.mktemp("files") / "study", small_study(["random"], (0.0, 0.3), 1, 3))
    figures = directory / "figures"
    figures.mkdir()
    for name in ("own.png", "fig4.txt", "people.svg"):
        (figures / name).write_bytes(b"")
    assert write_report(directory) == directory / "report.html"
    return directory


def test_all_files_are_there_and_no_draft_and_figures_that_are_no_longer_drawn_go(reported):
    names = {path.relative_to(reported).as_posix() for path in reported.rglob("*") if path.is_file()}
    assert {"report.html", "results.json", "tables/conditions.csv"} <= names
    assert {f"figures/{name}" for name in ("own.png", "fig4.txt", "fig4.svg")} <= names
    assert "figures/people.svg" not in names
    assert not [name for name in names if "draft" in name]
    assert [name for name in names if name.endswith(".html")] == ["report.html"]


def test_a_long_table_is_cut_where_it_says_so_and_draws_each_row_on_one_axis(found):
    ends = [(-0.5, -0.4, -0.3), (-0.1, 0.0, 0.1), (None, 0.2, None)] * 100
    rows = [Estimate(quantity="x", value=value, low=low, high=high) for low, value, high in ends]
    rows[0] = rows[0].model_copy(update={"p_value": 0.01})
    shown = Table("long", lambda found: [["agent", "x"], *([str(i), row] for i, row in enumerate(rows))], 1, "x")
    page = rendered("written", blocks=[shown], page=Page(found=found))
    assert page.count("<tr>") - 1 == page.count('<td class="pl">') == 200
    assert "100 more rows are in <code>tables/long.csv</code>" in page
    assert page.count("fd") == 1  # detected: filled
    places = [float(place) for place in re.findall(r'<b class="d[^"]*" style="left:([\d.]+)%', page)]
    axis = 1.05 * 0.5
    assert places == [pytest.approx(50 + 50 * row.value / axis, abs=0.01) for row in rows[:200]]


@pytest.mark.parametrize(
    ("cell", "written"),
    [
        *((f"{lead}1+1", f"'{lead}1+1") for lead in "=+-@"),
        ("\t1+1", "'?1+1"),
        ("\r1+1", "'?1+1"),
        ("a\nb\x00\x1b\t\u202e\u2066\u2069c", "a?b??????c"),
        ("Ünï ±5 % \u9501", "Ünï ±5 % \u9501"),
        ("1+1", "1+1"),
    ],
)
def test_no_cell_of_a_table_is_a_formula_or_holds_what_is_not_seen(cell, written):
    assert [*csv.reader(io.StringIO(as_csv([["agent", "p"], [cell, "0"]])))][1] == [written, "0"]


def test_a_page_with_open_trials_says_when_it_was_made_and_no_other_page_does(tmp_path, monkeypatch):
    study, pages = small_study(["random", "round-robin"], (0.0, 0.3), 1, 2), []
    for name, trials in (("open", play_study(study)[:3]), ("all", play_study(study))):
        directory = write_study(tmp_path / name, study, trials)
        for epoch in ("1795960920", "1796047320"):
            monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
            pages.append(write_report(directory).read_text("utf-8"))
    said = "3 of 8 trials.</strong> Made at {} November 2026; <code>lockprobe report DIR</code> makes it anew."
    assert all(said.format(at) in page for at, page in zip(("14:02 on 29", "14:02 on 30"), pages, strict=False))
    assert pages[0].replace("on 29 November", "on 30 November") == pages[1]
    assert pages[2] == pages[3]
    assert ("Not begun: round-robin." in pages[0], "Not begun" in pages[2], "Made at" in pages[2]) == (
        True,
        False,
        False,
    )
    assert [check.name for check in verify(tmp_path / "open") if not check.holds] == ["complete"]
