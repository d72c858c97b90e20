"""Every number on the pages is in results.json, rounded; and what was left out is counted."""

import re
from dataclasses import fields, is_dataclass, replace
from html.parser import HTMLParser
from importlib.resources import files
from itertools import chain

import pytest
from builders import make_trial, play_study, small_study, write_study
from pydantic import BaseModel

from lockprobe.analysis.inference.association import LENGTH_CAVEAT
from lockprobe.errors import BadFile
from lockprobe.report import write_report
from lockprobe.report.explorer import explorer_data
from lockprobe.report.figures import CAPTIONS
from lockprobe.report.opened import open_study
from lockprobe.report.page import _page, _tables
from lockprobe.report.results import results
from lockprobe.report.schema import Results
from lockprobe.trial_json import trial_to_json

NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")


class Text(HTMLParser):
    """What a reader sees."""

    def __init__(self, page):
        super().__init__()
        self.parts, self.hidden = [], False
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.hidden = tag == "style"

    def handle_data(self, data):
        if not self.hidden:
            self.parts.append(data)


def said(page):
    return NUMBER.findall(" ".join(Text(page).parts))


def marked(value, marks):
    """The same with every number replaced by one that nothing else could give; numbers in words stay."""
    if isinstance(value, BaseModel):
        found = {name: marked(inner, marks) for name, inner in value if name in value.model_fields_set}
        return value.model_copy(update=found)
    if is_dataclass(value):
        return replace(value, **{one.name: marked(getattr(value, one.name), marks) for one in fields(value)})
    if isinstance(value, dict):
        return {name: marked(inner, marks) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(marked(inner, marks) for inner in value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    marks.append(20_000 + len(marks))
    return type(value)(marks[-1])


def words(value):
    """All words of a JSON value, names included."""
    if isinstance(value, dict):
        return " ".join(f"{name} {words(inner)}" for name, inner in value.items())
    return " ".join(map(words, value)) if isinstance(value, list) else value if isinstance(value, str) else ""


def fixed(content):
    """Numbers that are words: of the templates, captions, heads of tables, and of the results' own words."""
    templates = files("lockprobe.report").joinpath("templates")
    sources = [
        re.sub(r"\{[{%#].*?[}%#]\}", " ", path.read_text("utf-8"), flags=re.DOTALL) for path in templates.iterdir()
    ]
    heads = [cell for table in _tables(content).values() for cell in table[0]]
    texts = (*sources, *chain(*CAPTIONS.values()), LENGTH_CAVEAT, *heads, words(content.plain()))
    return {x for text in texts for x in NUMBER.findall(text)}


def shown_as(marks):
    """Every way in which the pages write a number: whole, with digits, in per cent, with two figures."""
    forms = set()
    for mark in marks:
        for scale in (1, 100):
            forms |= {f"{scale * mark:.{digits}f}" for digits in range(3)} | {f"{scale * mark:g}", f"{mark:.2g}"}
    return forms


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    study = small_study(["human-inspired", "random"], (0.0, 0.2, 0.4, 0.6), 3, 5)
    directory = write_study(tmp_path_factory.mktemp("study"), study)
    write_report(directory)
    return directory


@pytest.mark.parametrize("name", ["report", "claims", "audit"])
def test_every_number_of_a_page_is_in_the_results(reported, name):
    """With every number of the results replaced by a mark, the page shows marks and nothing else."""
    marks = []
    content = marked(Results.model_validate_json((reported / "results.json").read_text("utf-8")), marks)
    page = _page(name, content, {})
    allowed, forms = fixed(content), shown_as(marks)
    shown = [token for token in said(page) if token not in allowed]
    assert len(shown) > 10
    assert [token for token in shown if token not in forms] == []


def test_the_page_on_disk_is_made_of_the_results_on_disk(reported):
    content = Results.model_validate_json((reported / "results.json").read_text("utf-8"))
    drawn = {
        path.stem: {"svg": path.read_bytes()} for path in (reported / "figures").iterdir() if path.suffix == ".svg"
    }
    opened = open_study(reported)
    trials = explorer_data(opened.trials, opened.settings["box"])
    for name in ("report", "claims", "audit"):
        assert (reported / f"{name}.html").read_text("utf-8") == _page(name, content, drawn, trials=trials)


def test_what_is_left_out_is_counted(tmp_path):
    study = small_study(["random"], (0.0, 0.3), 1, 3)
    trials = play_study(study)
    broken = make_trial([0], p=0.3, trial=3, broken="reply")
    again = make_trial([0], p=0.0, trial=1, broken="model")
    foreign = replace(trials[0], key="flips/random/truth/rep=9/trial=1", repetition=9)
    kept = [trial for trial in trials if trial.key != broken.key]
    directory = write_study(tmp_path / "study", study, [again, *kept, broken, foreign])
    with (directory / "trials.jsonl").open("ab") as file:
        file.write(trial_to_json(trials[0])[:50])
    found = results(directory).plain()
    assert found["left_out"] == {
        "errors": 1, "replayed_on_request": 0, "replaced_after_an_error": 1, "repeated": 0, "unfinished_lines": 1,
        "not_asked_for": 1, "foreign": 0,
    }  # fmt: skip
    assert sum(row["trials"] for row in found["conditions"]) == 5
    text = " ".join(" ".join(Text(write_report(directory).read_text("utf-8")).parts).split())
    assert "1 trials that ended as error, 1 incomplete lines of the journal, 1 trials outside the settings" in text


def test_trials_of_another_box_are_refused_in_one_line(tmp_path):
    study = small_study(["random"], (0.0,), 1, 2)
    first, second = play_study(study)
    directory = write_study(tmp_path / "study", study, [first, replace(second, box="chain-5")])
    with pytest.raises(BadFile, match="boxes chain-4, chain-5', expected trials of one box"):
        results(directory)
