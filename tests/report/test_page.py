"""A report is whole, the same from the same records, and safe to open."""

import csv
import io
import json
import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from html import unescape
from html.parser import HTMLParser

import pytest
from builders import SOLUTION, make_trial, play_study, small_study, write_study

from lockprobe.errors import BadFile
from lockprobe.interventions.condition import flips
from lockprobe.lockbox.families import box
from lockprobe.prose.loops import LOOP_DEFINITION
from lockprobe.record import TrialError
from lockprobe.report import write_report
from lockprobe.report.figures import _STARS as STARS_OF
from lockprobe.report.figures import CAPTIONS
from lockprobe.report.page import _page
from lockprobe.report.results import results
from lockprobe.studies.study import Study

ATTACK = "<script>alert('x')</script><img src=https://evil.example/x onerror=alert(1)>"
CHANCE = {"loop_rate_chance_markov", "loop_rate_chance_permutation"}
FIELDS = {
    "loop_rate_low",
    "success_high",
    "misinterpretation_rate",
    "success_low",
    "p",
    "loop_rate_high",
    "loop_rate_chance",
    "key",
    "loop_rate_chance_no_repeat",
    "agent",
    "trials",
    "redundant_share",
    "solved",
    "loop_rate",
    "coverage",
    "misinterpretations",
    "median_steps",
    "success",
}


@pytest.fixture(scope="module")
def reported(tmp_path_factory, drawn):
    directory = write_study(tmp_path_factory.mktemp("study"), small_study())
    with drawn("fig4"):
        assert write_report(directory) == directory / "report.html"
    return directory


@pytest.fixture(scope="module")
def content(reported):
    return json.loads((reported / "results.json").read_text("utf-8"))


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.loads = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.loads += [value for name, value in attrs if name in ("src", "href", "srcset", "data", "action")]


def page_of(directory, name="report"):
    return (directory / f"{name}.html").read_text("utf-8")


def test_all_files_are_there_and_no_draft(reported):
    names = {path.relative_to(reported).as_posix() for path in reported.rglob("*") if path.is_file()}
    asked = [name for name in CAPTIONS if name not in ("people", "forks")]  # of studies that have them
    pictures = {f"figures/{name}.{form}" for form in ("png", "svg") for name in asked}
    made = ("table1", "table1-corrected", "courses", "speed", "paces", "loops", "rationality")
    made += ("detectors", "conditions", "claims")
    tables = {f"tables/{name}.{form}" for form in ("csv", "tex") for name in made}
    assert pictures | tables | {"report.html", "claims.html", "audit.html", "results.json"} <= names
    assert not [name for name in names if "draft" in name]


def test_results_have_the_promised_fields(reported, content):
    assert content == results(reported).plain()
    assert content["schema_version"] == 3
    assert content["progress"] == {"planned": 48, "finished": 48, "partial": False}
    assert [c["key"] for c in content["conditions"][:2]] == ["flips/random/truth", "flips/random/flip?p=0.3"]
    for condition in content["conditions"]:
        assert set(condition) >= FIELDS
        assert condition["trials"] == 8
        assert 0 <= condition["success_low"] <= condition["success"] <= condition["success_high"] <= 1
        assert 0 <= condition["loop_rate_low"] <= condition["loop_rate"] <= condition["loop_rate_high"] <= 1
        assert condition["loop_rate_chance"] <= condition["loop_rate_chance_no_repeat"]


def test_every_figures_numbers_are_in_the_results(content):
    for condition in content["conditions"]:
        curve = condition["curve"]
        assert len(curve["steps"]) == len(curve["share"]) == len(curve["low"]) == len(curve["high"]) == 21
        assert curve["share"][-1] == condition["success"]
        assert sum(point["n"] for point in condition["repetitions"]) == condition["trials"]
        assert {"p", "success", "loop_rate", "repetition"} <= set(condition["repetitions"][0])
    (human,) = (fit for fit in content["fits"] if fit["agent"] == "human-inspired")
    band = human["success"]["quadratic"]
    assert len(band["p"]) == len(band["value"]) == len(band["low"]) == len(band["high"])
    assert {"r", "n", "low", "high", "caveat"} <= set(human["correlation"])


def test_equal_records_give_equal_reports(tmp_path, drawn):
    study = small_study(["human-inspired"], (0.0, 0.3), 1, 4)
    trials = play_study(study)
    first = write_study(tmp_path / "a", study, trials)
    second = write_study(tmp_path / "b", study, reversed(trials))
    (second / "timings.jsonl").write_text("")
    with drawn("fig4"):
        written = [write_report(first), write_report(second)]
    for name in ("results.json", "report.html", "claims.html", "figures/fig4.svg", "tables/conditions.csv"):
        assert (first / name).read_bytes() == (second / name).read_bytes()
    assert written == [first / "report.html", second / "report.html"]


@pytest.mark.parametrize("name", ["report", "claims", "audit"])
def test_the_pages_load_nothing_and_run_nothing(reported, name):
    page = Page(page_of(reported, name))
    links = {load for load in page.loads if not load.startswith("data:image/")}
    assert {link for link in links if not link.startswith("#")} <= {"report.html", "claims.html", "audit.html"}
    assert not {"link", "iframe", "object", "svg"} & set(page.tags)
    assert page.tags.count("script") == (2 if name == "report" else 0)  # the trials as JSON, and our own program
    text = page_of(reported, name)
    assert set(re.findall(r"https?://[^\"]*", text)) <= {"http://www.w3.org/2000/svg"}
    policy = re.search(r'Security-Policy" content="([^"]*)"', text)[1]
    assert "default-src 'none'" in policy
    hashes = re.findall(r"script-src '(sha256-[^']*)'", policy)
    programs = re.findall(r"(?s)<script>(.*?)</script>", text)
    assert hashes == [f"sha256-{b64encode(sha256(one.encode()).digest()).decode()}" for one in programs]


def test_links_within_the_page_lead_somewhere(reported):
    text = page_of(reported)
    inside = [load[1:] for load in Page(text).loads if load.startswith("#")]
    assert inside
    assert all(f'id="{place}"' in text for place in inside)


def test_what_models_say_is_escaped(tmp_path):
    said = {"agent": "llm:evil/" + "<b>x</b>", "hypothesis": ATTACK, "facts": {"model": ATTACK}}
    trials = [make_trial(SOLUTION, p=p, trial=i, **said) for p in (0.0, 0.3) for i in (1, 2)]
    trials += [make_trial([0, 1, 2] * 4, budget=12, p=0.0, trial=3, claims=[None, "moved"], **said)]
    study = small_study([said["agent"]], (0.0, 0.3), 1, 3)
    directory = write_study(tmp_path / "study", study, trials)
    page = Page(write_report(directory).read_text("utf-8"))
    assert page.tags.count("script") == 2
    assert page.tags.count("b") == 3  # the three numbers
    assert not [load for load in page.loads if "evil" in load]
    assert "script" not in Page(page_of(directory, "claims")).tags
    assert "&lt;script&gt;" in page_of(directory)


def test_no_name_hides_or_reorders_what_stands_beside_it(tmp_path):
    name = "llm:evil/\u202ea\u2066b\nc\x1bd"
    trials = [make_trial(SOLUTION, p=p, hypothesis=name, agent=name, facts={"model": name}) for p in (0.0, 0.3)]
    directory = write_study(tmp_path / "study", small_study([name], (0.0, 0.3), 1, 1), trials)
    write_report(directory)
    for page in ("report", "claims"):
        text = page_of(directory, page)
        assert "<code>llm:evil/?a?b c?d</code>" in text
        assert all(line.isprintable() for line in text.split("\n"))
    assert json.loads((directory / "results.json").read_text("utf-8"))["conditions"][0]["agent"] == name


def test_the_page_says_what_was_found_and_under_what(reported, content):
    text = page_of(reported)
    for finding in content["findings"]:
        assert finding.replace("'", "&#39;") in text.replace("<i>P</i>", "P")
    for needed in ("reconstruction", "transient", "human-inspired", "Limits", "Seed", "false positives", "claims.html"):
        assert needed in text
    assert "Partial" not in text


def test_a_study_of_many_agents_begins_with_who_rises_and_who_falls(tmp_path):
    agents = ("cognitive:careful", "cognitive:perseverant", "human-inspired?lapse=0.3", "llm:local")
    trials = [
        make_trial(SOLUTION if i < solved else (0,) * 20, agent=agent, p=p, trial=1 + (i + round(7 * p)) % 30)
        for agent, rises in zip(agents, (False, True, False, True), strict=True)
        for p, solved in ((0.0, 5 if rises else 25), (0.4, 25 if rises else 5))
        for i in range(30)
    ]
    study = Study(
        name="flips", agents=agents, box=box("chain-4"), conditions=flips((0.0, 0.4)), repetitions=1, trials=30, seed=1
    )
    directory = write_study(tmp_path, study, trials)
    write_report(directory)
    content = json.loads((directory / "results.json").read_text())
    said = (
        "higher at some flip rate for cognitive:perseverant, llm:local; lower for cognitive:careful, "
        "human-inspired?lapse=0.3"
    )
    assert (
        content["courses_said"]
        == f"Success compared with a flip rate of 0: {said}. Tests are corrected for 3 agents and, apart, for 1 baseline (Bonferroni)."
    )
    page = page_of(directory)
    assert page.index(said) < page.index("Agent by agent") < page.index(content["findings"][0][:60])


def test_a_prior_that_true_reports_contradict_is_said_to_be_wrong(tmp_path):
    """A target that needs two joints open is in none of the priors."""
    both = {"revolute-left": ({"slider-1": True, "slider-2": True},)}
    study = replace(small_study(["random"], (0.0,), 1, 6), box=replace(box("chain-4"), name="both", interlock=both))
    content = results(write_study(tmp_path / "both", study))
    assert "On this box true reports contradict this prior" in _page("report", content, {})
    assert not results(write_study(tmp_path / "fine", small_study(["random"], (0.0,), 1, 6))).judged.prior_contradicted


def test_every_best_flip_rate_says_whose_it_is(tmp_path):
    agents = ["cognitive:perseverant", "cognitive:random-map?window=1&avoid=last"]
    content = results(write_study(tmp_path, small_study(agents, (0.0, 0.2, 0.4, 0.6), 1, 10)))
    assert None in [fit.binomial.order for fit in content.fits]  # one without a model has its name too
    page = _page("report", content, {"fig4-corrected": {"svg": b"<svg/>"}})
    caption = page.partition("95 % set of the best flip rate")[2].partition("</figcaption>")[0]
    named = re.findall(r"<code>(.*?)</code>:(?: AICc prefers order \d\.)? Success is highest", caption)
    assert len(named) == caption.count("Success is highest") == 2


def test_boxes_too_large_for_a_prior_are_not_judged(tmp_path):
    study = replace(small_study(["random"], (0.0,), 1, 3), box=box("chain-7"))
    content = results(write_study(tmp_path / "study", study))
    assert content.rationality == []
    assert content.judged.left_out_for_want_of_a_prior == 3
    assert "there is no prior for boxes with this number of joints (3 trials)" in _page("report", content, {})


def test_every_condition_is_judged_by_two_observers(reported, content):
    rows = content["rationality"]
    assert [(row["key"], row["noise"]) for row in rows] == [
        (condition["key"], noise) for condition in content["conditions"] for noise in ("naive", "aware")
    ]
    for row in rows:
        assert {"optimal", "regret", "uninformative", "expected"} == set(row["by_chance"])
        assert row["trials"] == 8
        assert row["optimal"]["low"] <= row["optimal"]["value"] <= row["optimal"]["high"]
    table = list(csv.DictReader(io.StringIO((reported / "tables" / "rationality.csv").read_text())))
    assert len(table) == 4  # a blind agent once, the other at every p


def test_a_partial_study_says_so(tmp_path):
    study = small_study(["random"])
    trials = play_study(study)[:5]
    broken = make_trial([0], agent="random", p=0.3, repetition=2, trial=4, broken="model")
    directory = write_study(tmp_path / "study", study, [*trials, broken])
    content = json.loads((write_report(directory).parent / "results.json").read_text())
    assert content["progress"] == {"planned": 24, "finished": 5, "partial": True}
    assert "Partial: 5 of 24 trials." in page_of(directory)
    assert "it broke" in page_of(directory)


def test_a_study_that_has_only_begun_can_be_reported(tmp_path):
    directory = write_study(tmp_path / "study", small_study(), [])
    assert "No trial has been played yet." in write_report(directory).read_text("utf-8")
    assert results(directory).conditions == []


def test_only_errors_can_be_reported(tmp_path):
    broken = make_trial([], agent="random", p=0.3, broken="model")
    directory = write_study(tmp_path / "study", small_study(["random"]), [broken])
    write_report(directory)
    (condition,) = json.loads((directory / "results.json").read_text())["conditions"]
    assert (condition["trials"], condition["success"], condition["errors"]) == (0, None, {"model": 1})


def test_figures_that_are_no_longer_drawn_go(tmp_path):
    broken = make_trial([], agent="random", p=0.3, broken="model")
    directory = write_study(tmp_path / "study", small_study(["random"]), [broken])
    figures = directory / "figures"
    figures.mkdir()
    for name in ("own.png", "fig4.txt", *(f"{name}.{form}" for name in CAPTIONS for form in ("png", "svg"))):
        (figures / name).write_bytes(b"")
    write_report(directory)
    assert {path.name for path in figures.iterdir()} == {"own.png", "fig4.txt", "box.png", "box.svg"}


def test_a_directory_without_a_study_is_refused(tmp_path):
    with pytest.raises(BadFile):
        write_report(tmp_path)


def test_tables_are_those_of_the_results(reported, content):
    rows = list(csv.DictReader(io.StringIO((reported / "tables" / "conditions.csv").read_text())))
    conditions = content["conditions"]
    assert [(row["agent"], row["solved"]) for row in rows] == [(c["agent"], str(c["solved"])) for c in conditions]
    tex = (reported / "tables" / "conditions.tex").read_text()
    assert tex.count(r"\\") == len(conditions) + 1
    assert not re.search(r"(?<!\\)%", tex)


def test_rows_of_a_table_stand_without_quotation_marks(reported):
    page = page_of(reported, "claims")
    assert "Table entry: State Misinterpretation Rates Across Input Modalities, row RGB-D" in page
    assert "\u201cState Misinterpretation" not in page
    assert "\u201cperformance rises to a peak" in page


def test_a_caption_names_stars_only_where_they_are_drawn(reported):
    """The study has a flip rate of 0, so the figure by step has stars; without them the caption names none."""
    content = results(reported)
    page_with = lambda name, svg: unescape(_page("report", content, {name: {"svg": svg}}))  # noqa: E731
    star = b'<svg width="1pt"><g id="paper"></g></svg>'
    for name in ("fig3", "overview"):
        stars = STARS_OF[name]
        assert stars not in page_with(name, b'<svg width="1pt"></svg>')
        assert stars in page_with(name, star)
    assert "Zenkri and Brock" in page_of(reported)


def test_a_test_that_is_not_valid_has_no_plain_yes(reported):
    content = results(reported)
    invalid = {rate.test for rate in content.audit.rates if rate.valid is False and not rate.recommended}
    tests = [replace(test, rejects=True, p_value=0.01) for test in content.tests]
    page = _page("report", content.model_copy(update={"tests": tests}), {})
    tests_shown = page.partition('id="tests"')[2].partition('id="said"')[0]
    shown = [test for test in tests if test.agent in content.subjects]
    assert tests_shown.count("<td>not valid (rejects)") == sum(test.name in invalid for test in shown) > 0
    assert tests_shown.count("<td>yes") == sum(test.name not in invalid for test in shown)


def test_an_action_loop_is_defined_where_it_is_first_named(reported):
    text = page_of(reported)
    findings, loops = (text.partition(f'id="{name}"')[2].partition("</details>\n")[0] for name in ("findings", "loops"))
    assert LOOP_DEFINITION in findings
    assert f"{LOOP_DEFINITION} A loop is no fault by itself" in loops


def test_refusals_and_tidied_replies_are_counted_by_agent(tmp_path):
    study = small_study(["random"])
    first, *others = play_study(study)
    refused = replace(
        make_trial([0], agent="random", p=0.3, repetition=2, trial=4, broken="model"),
        error=TrialError(boundary="refusal", message="refused: I cannot help.", step=2),
    )
    decision = replace(first.steps[0].decision, replies=("```{}```",), tidied=("fence", "prose"))
    first = replace(first, steps=(replace(first.steps[0], decision=decision), *first.steps[1:]))
    directory = write_study(tmp_path / "study", study, [first, *others[:4], refused])
    content = json.loads((write_report(directory).parent / "results.json").read_text())
    (row,) = content["errors"]
    assert (row["boundary"], row["message"], row["owed_again"]) == ("refusal", "refused: I cannot help.", False)
    (tidied,) = content["tidied"]
    assert (tidied["agent"], tidied["tidied"]) == ("random", 1)
    assert tidied["decisions"] == sum(len(trial.steps) for trial in (first, *others[:4], refused))
    assert tidied["what"] == {"a code fence": 1, "text around the object": 1}
    page = page_of(directory)
    assert "They were tidied, and count as all others do." in page
    assert "refused: I cannot help." in page
    assert sum(condition["failed"] for condition in content["conditions"] if "failed" in condition) == 0
