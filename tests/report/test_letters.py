"""On the pages p is no letter of two meanings, and captions are short: two sentences each on what is shown and how."""

import json
import re
from html import unescape
from pathlib import Path

import pytest
from builders import make_trial, modality_study, play_study, played_by_people, small_study, write_study
from captions import captions, too_long
from page_parts import part

from lockprobe.report.write import write_report

AGENT = "llm:x"


def with_a_subject():
    """An agent whose success rises, beside one that is blind, with a trial that broke."""
    rises = {0.0: 2, 0.3: 7, 0.6: 9}
    trials = [
        make_trial([3, 2, 1, 0] if i <= solved else [0] * 20, agent=AGENT, p=p, trial=i, claims=[None, "moved"])
        for p, solved in rises.items()
        for i in range(1, 11)
    ]
    trials[-1] = make_trial([0], agent=AGENT, p=0.6, trial=10, broken="reply")
    study = small_study((AGENT, "random"), tuple(rises), 1, 10)
    return study, [*trials, *(trial for trial in play_study(study_of_random(study)) if trial.agent == "random")]


def study_of_random(study):
    return small_study(("random",), study.p, 1, study.trials)


def with_people():
    study = small_study(("participant", "round-robin"), (0.0, 0.6), 1, 6)
    return study, [*played_by_people(study, 2), *play_study(small_study(("round-robin",), study.p, 1, 6))]


def modal():
    ways = ("rgb", "rgbd", "symbolic")
    trials = [
        make_trial([0] * wait + [3, 2, 1, 0], agent="viewer", modality=way, study="modalities", trial=i, claims=[None])
        for wait, way in enumerate(ways)
        for i in range(1, 9)
    ]
    return modality_study(("viewer",), ways, 8), trials


@pytest.fixture(scope="module", params=[with_a_subject, with_people, modal], ids=["subject", "people", "modal"])
def directory(request, tmp_path_factory):
    found = write_study(tmp_path_factory.mktemp("study") / "out", *request.param())
    write_report(found)
    return found


def words(page):
    """The text of a page without what is quoted or a name: the paper's words, specs and keys."""
    page = re.sub(r"(?s)<(style|script|code|blockquote)\b.*?</\1>", " ", page)
    return unescape(re.sub(r"<(?!/?[iI]>)[^>]*>", "\n", page))


@pytest.mark.parametrize("name", ["report", "details", "claims"])
def test_a_flip_rate_is_written_out_and_the_p_of_a_p_value_is_a_capital(directory, name):
    page = words((directory / f"{name}.html").read_text("utf-8"))
    page = page.replace("lip rate <i>p</i>", "lip rate").replace("p-value", "")
    assert not re.findall(r".{0,40}(?<!-)\bp\b(?!-).{0,40}", page)
    assert not re.findall(r"[^>]\bP\b [=<] ", page)  # in italics wherever it has a value


def test_every_p_value_of_a_sentence_is_a_capital(directory):
    page = (directory / "report.html").read_text("utf-8") + (directory / "claims.html").read_text("utf-8")
    assert re.search(r"<i>P</i> (=|&lt;) [01]", page)


def test_a_test_that_does_not_reject_says_not_detected_and_no_number_has_a_star(directory):
    page, details = ((directory / f"{name}.html").read_text("utf-8") for name in ("report", "details"))
    cells = re.findall(r"<td[^>]*>(.*?)</td>", part(details, "hypothesis_tests"))
    says = [re.sub("<[^>]*>", "", cell.partition("<br>")[0]) for cell in cells[5::6]]
    assert set(says) <= {"yes", "not valid (rejects)", "not detected", "\N{EN DASH}"}
    assert ("not detected" in says) == bool(says)
    overview = re.findall(r"<td(?! class=\"who\")[^>]*>(.*?)</td>", part(page, "hypothesis_tests"))
    concluded = [re.sub(r" \([^()]*\)", "", cell) for cell in overview]
    assert set(concluded) <= {"detected", "not detected", "\N{EN DASH}"}
    assert ("not detected" in concluded) == ("not detected" in says)
    assert not re.search(r"\d ?\*", words(page) + words(details))


@pytest.mark.parametrize("name", ["report", "details", "claims"])
def test_captions_say_in_two_sentences_what_is_shown_and_in_two_how_it_was_computed(directory, name):
    page = (directory / f"{name}.html").read_text("utf-8")
    results = json.loads((directory / "results.json").read_text("utf-8"))
    assert too_long(page, results) == []
    found = captions(page, results)
    assert len(found) > {"report": 20, "details": 8, "claims": 2}[name]
    assert any(computed for _, computed in found)
    assert name in {"details", "claims"} or "How is this computed?" in page


def test_a_caption_with_a_third_sentence_or_with_semicolons_in_its_place_is_found():
    note = '<div class="note">Fig. 4. “A. B. C.” It is 2.5. {}<span class="computed">So. {}</span>{}</div>'
    assert too_long(note.format("", "", '<details class="how"><summary>How?</summary>One. Two. Three.</details>')) == []
    for more in [("This. ", "", ""), ("", "This. Too.", ""), ("", "", "<p>More.</p>"), ("", f"So {'on; ' * 50}", "")]:
        assert len(too_long(note.format(*more))) == 1
    assert too_long("<p>One. Two. Three.</p>", {"said": ["One.", "Two.", "Three."]}) == []
    assert len(too_long("<figcaption>One. Two. Three.</figcaption>", {"said": ["One."]})) == 1


def test_the_report_says_which_agent_it_is_about(tmp_path):
    page = write_report(write_study(tmp_path / "out", *with_a_subject())).read_text("utf-8")
    assert "<dt>Agent</dt><dd><code>llm:x</code>: the subject of this report" in page
    assert "<dt>Baselines</dt><dd><code>random</code></dd>" in page


def test_columns_of_csv_files_keep_their_names(directory):
    for name in ("speed", "loops", "conditions", "comparisons-by-p"):
        head = (directory / "tables" / f"{name}.csv").read_text("utf-8").splitlines()[0]
        assert "p" in head.split(",")
        assert "flip rate" not in head
    assert (directory / "tables" / "claims.csv").read_text("utf-8").splitlines()[0].endswith(",p")


def test_the_documentation_writes_flip_rates_out():
    root = Path(__file__).parents[2]
    for path in [
        root / "README.md",
        *sorted({*(root / "docs").glob("*.md"), *(root / "robot" / "docs").glob("*.md")}),
    ]:
        prose = re.sub(r"(?s)```.*?```|`[^`\n]*`|\n    [^\n]*", "", path.read_text("utf-8"))
        assert not re.findall(r".*(?<![-\w])p\b(?![-=]).*", prose), path.name
