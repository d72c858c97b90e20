"""A report is whole, the same from the same records, and safe to open."""

import csv
import io
import re
from base64 import b64encode
from hashlib import sha256
from html.parser import HTMLParser
from types import SimpleNamespace

import pytest
from builders import SOLUTION, make_trial, play_study, small_study, write_study
from jinja2 import UndefinedError
from reported import found_in

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.left_out import leaving_out
from lockprobe.foundation.terminal_text import printable
from lockprobe.report import page as made
from lockprobe.report.format import as_csv
from lockprobe.report.page import page_of
from lockprobe.report.questions import all_sections
from lockprobe.report.rendering import _breakable, rendered
from lockprobe.report.rows import Estimate, LeftOut, Results
from lockprobe.report.section import Table
from lockprobe.report.svg import image
from lockprobe.report.write import write_report

ATTACK = "<script>alert('x')</script><img src=https://evil.example/x onerror=alert(1)>"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return found_in(tmp_path_factory.mktemp("page"), small_study())


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.loads = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.loads += [value for name, value in attrs if name in ("src", "href", "srcset", "data", "action")]


def test_the_page_loads_nothing_and_runs_one_program_of_ours(found):
    picture = image(b"<svg />")
    text = page_of(found, {figure.name: picture for of in all_sections() for figure in of.figures})
    page = Page(text)
    assert all(load.startswith(("data:image/", "#")) for load in page.loads)
    assert not {"link", "iframe", "object"} & set(page.tags)
    assert page.tags.count("script") == 2  # the trials as JSON, and the program
    assert set(re.findall(r"https?://[\w./]*", text)) <= {"http://www.w3.org/2000/svg"}
    policy = re.search(r'Security-Policy" content="([^"]*)"', text)[1]
    assert "default-src 'none'" in policy
    hashes = re.findall(r"script-src '(sha256-[^']*)'", policy)
    programs = re.findall(r"(?s)<script>(.*?)</script>", text)
    assert hashes == [f"sha256-{b64encode(sha256(one.encode()).digest()).decode()}" for one in programs]


def test_equal_records_give_equal_results_and_pages(tmp_path):
    study = small_study(["human-inspired"], (0.0, 0.3), 1, 4)
    trials = play_study(study)
    first, second = (found_in(tmp_path / name, study, made) for name, made in (("a", trials), ("b", reversed(trials))))
    assert first == second
    assert page_of(first) == page_of(second)


def test_what_models_say_is_escaped(tmp_path):
    said = {"agent": "llm:evil/" + "<b>x</b>", "hypothesis": ATTACK, "facts": {"model": ATTACK}}
    trials = [make_trial(SOLUTION, p=p, trial=i, **said) for p in (0.0, 0.3) for i in (1, 2)]
    trials += [make_trial([0, 1, 2] * 4, budget=12, p=0.0, trial=3, claims=[None, "moved"], **said)]
    found = found_in(tmp_path, small_study([said["agent"]], (0.0, 0.3), 1, 3), trials)
    text = page_of(found)
    page = Page(text)
    assert page.tags.count("script") == 2
    assert not [load for load in page.loads if "evil" in load]
    assert "img" not in page.tags
    assert "&lt;script&gt;" in text
    assert "<b>x</b>" not in text


def test_no_name_hides_or_reorders_what_stands_beside_it(tmp_path):
    name = "llm:evil/\u202ea\u2066b\nc\x1bd"
    trials = [make_trial(SOLUTION, p=p, hypothesis=name, agent=name, facts={"model": name}) for p in (0.0, 0.3)]
    found = found_in(tmp_path, small_study([name], (0.0, 0.3), 1, 1), trials)
    text = page_of(found)
    assert "llm:evil/?a?b c?d" in text
    assert all(line.isprintable() for line in text.split("\n"))
    assert found.cells[0].agent == name


def test_a_partial_study_says_so_and_names_what_broke(tmp_path):
    study = small_study(["random"])
    broken = make_trial([0], agent="random", p=0.3, repetition=2, trial=4, broken="model")
    found = found_in(tmp_path, study, [*play_study(study)[:5], broken])
    assert (found.progress.planned, found.progress.finished, found.progress.partial) == (24, 5, True)
    text = page_of(found)
    assert "Partial: 5 of 24 trials." in text
    assert "it broke" in text


def test_only_errors_can_be_reported(tmp_path):
    broken = make_trial([], agent="random", p=0.3, broken="model")
    found = found_in(tmp_path, small_study(["random"]), [broken])
    (cell,) = found.cells
    assert (cell.trials, cell.get("success"), cell.value("broken", "model")) == (0, None, 1)
    assert "it broke" in page_of(found)


def test_what_could_not_be_made_is_named_at_the_top(found):
    failed = found.changed(sections_left_out=(LeftOut(section="Loops", reason="ValueError: no"),))
    assert "<li>Loops (ValueError: no)</li>" in page_of(failed)
    assert "Left out, because" not in page_of(found)


def test_a_page_without_its_first_screen_or_its_frame_says_so(found, monkeypatch):
    without = found.changed(findings=tuple(one for one in found.findings if one.section != "overview"))
    text = page_of(without)
    assert "The first screen could not be written" in text
    assert 'id="limits"' in text
    monkeypatch.setattr(made, "parts_of", lambda *asked: 1 / 0)
    with leaving_out():
        assert "This page could not be written" in page_of(found)


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    directory = write_study(tmp_path_factory.mktemp("files") / "study", small_study(["random"], (0.0, 0.3), 1, 3))
    figures = directory / "figures"
    figures.mkdir()
    for name in ("own.png", "fig4.txt", "people.png", "people.svg", "box.png"):
        (figures / name).write_bytes(b"")
    assert write_report(directory) == directory / "report.html"
    return directory


def test_all_files_are_there_and_no_draft(reported):
    names = {path.relative_to(reported).as_posix() for path in reported.rglob("*") if path.is_file()}
    assert {"report.html", "results.json", "tables/conditions.csv", "figures/fig4.svg"} <= names
    assert not [name for name in names if "draft" in name]
    assert [name for name in names if name.endswith(".html")] == ["report.html"]


def test_figures_that_are_no_longer_drawn_go(reported):
    figures = {path.name for path in (reported / "figures").iterdir()}
    assert {"own.png", "fig4.txt", "fig4.svg", "fig4.png", "box.svg"} <= figures
    assert not {"people.png", "people.svg", "box.png"} & figures


def test_tables_are_those_of_the_results(reported):
    found = Results.model_validate_json((reported / "results.json").read_text("utf-8"))
    solved = [cell.get("success").count for cell in found.cells]
    table = list(csv.DictReader(io.StringIO((reported / "tables" / "conditions.csv").read_text())))
    assert [row["solved"] for row in table] == [str(count) for count in solved]


def test_a_directory_without_a_study_is_refused(tmp_path):
    with pytest.raises(BadFile):
        write_report(tmp_path)


def test_text_is_escaped_and_a_missing_value_is_an_error():
    study = SimpleNamespace(name="<img src=x>", partial=False, looked_at=False)
    content = SimpleNamespace(studies=[study], box="<b>", said="A & B\u202e", unlike=["<i>"], differences=())
    values = {"lockprobe": "1", "plots": {"differences": [], "rest": []}, "tables": {}}
    with pytest.raises(UndefinedError):
        rendered("compare", content=content, **values)
    rows = [["study"], ["<script>"]]
    values["tables"] = dict.fromkeys(("studies", "success", "differences", "rest"), rows)
    page = rendered("compare", content=content, **values)
    assert not any(attack in page for attack in ("<img src=x", "<b>", "<script>", "\u202e"))
    assert "&lt;img src=x&gt;" in page


def test_a_long_table_is_cut_where_it_says_so_and_draws_each_row_on_one_axis(found):
    ends = [(-0.5, -0.4, -0.3), (-0.1, 0.0, 0.1), (None, 0.2, None)] * 100
    rows = [Estimate(quantity="x", value=value, low=low, high=high) for low, value, high in ends]
    rows[0] = rows[0].model_copy(update={"p_value": 0.01})
    shown = Table("long", lambda found: [["agent", "x"], *([str(i), "1"] for i in range(300))], 1, lambda found: rows)
    page = rendered("written", blocks=[shown], page=made.Page(found=found))
    assert page.count("<tr>") - 1 == page.count('<td class="pl">') == 200
    assert "100 more rows are in <code>tables/long.csv</code>" in page
    assert page.count("fd") == 1  # detected: filled
    places = [float(place) for place in re.findall(r'<b class="d[^"]*" style="left:([\d.]+)%', page)]
    axis = 1.05 * 0.5
    assert places == [pytest.approx(50 + 50 * row.value / axis, abs=0.01) for row in rows[:200]]


def test_a_spec_breaks_after_its_marks_and_never_within_a_tag():
    assert _breakable("llm:a/b") == "llm:<wbr>a/<wbr>b"
    assert _breakable("learner:P < 1/x") == "learner:<i>P</i> &lt; 1/<wbr>x"


HOSTILE = "a\nb\x00\x1b\t\u202e\u2066\u2069c"


def test_what_is_not_seen_is_a_question_mark():
    assert printable(HOSTILE) == "a?b??????c"
    assert printable("Ünï ±5 % \u9501") == "Ünï ±5 % \u9501"


@pytest.mark.parametrize("lead", ["=", "+", "-", "@", "\t", "\r"])
def test_no_cell_is_a_formula(lead):
    ((cell, plain),) = csv.reader(io.StringIO(as_csv([[f"{lead}1+1", "1+1"]])))
    assert cell == f"'{printable(lead)}1+1"
    assert plain == "1+1"


def test_nothing_invisible_is_in_a_file():
    table = [["agent", "p"], [HOSTILE, "0"]]
    assert as_csv(table) == "agent,p\na?b??????c,0\n"
