"""Every number on the pages is in results.json, rounded; and what was left out is counted."""

import re

import pytest
from builders import make_trial, play_study, small_study, write_study
from pydantic import BaseModel
from report.page_text import page_text
from reported import tables_of

from lockprobe.report.page import Page, write_report
from lockprobe.report.results import results
from lockprobe.report.rows import Results

NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")


def marked(value, first, marks):
    """The same with every number replaced by one that nothing else could give, equal ones by the same."""
    if isinstance(value, BaseModel):
        found = {name: marked(inner, first, marks) for name, inner in value if name in value.model_fields_set}
        return value.model_copy(update=found)
    if isinstance(value, dict):
        return {name: marked(inner, first, marks) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(marked(inner, first, marks) for inner in value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    return type(value)(marks.setdefault((type(value), value), first + len(marks) * first // 20_000))


def shown_as(number):
    """Every way in which the pages write a number: whole, with digits, in per cent, with two figures."""
    forms = {f"{scale * number:.{digits}f}" for scale in (1, 100) for digits in range(3)}
    return forms | {f"{scale * number:g}" for scale in (1, 100)} | {f"{number:.2g}"}


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    study = small_study(["human-inspired", "random"], (0.0, 0.2, 0.4, 0.6), 3, 5)
    directory = write_study(tmp_path_factory.mktemp("study"), study)
    write_report(directory)
    return directory


@pytest.fixture(scope="module")
def twice(reported):
    """The results with all numbers replaced by marks, in two ways, and how the marks are written."""
    found = Results.model_validate_json((reported / "results.json").read_bytes())
    made = []
    for first in (20_000, 60_000):
        content = marked(found, first, marks := {})
        gaps = [one.value("loop_rate") - one.value("loop_rate", "uniform") for one in content.cells]
        made.append((content, {form for one in (*marks.values(), *map(abs, gaps)) for form in shown_as(one)}))
    return made


@pytest.mark.parametrize("name", ["report", "tables"])
def test_every_number_of_a_page_is_in_the_results(twice, name):
    """What differs between two pages whose results differ in all numbers are these numbers, and loops above chance."""

    def seen(found):
        if name == "tables":
            return str(tables_of(found))
        return " ".join(page_text(re.sub(r'(?s)<div class="r ax".*?</div>', "", Page(found=found).text())))

    (shown, forms), (again, others) = ((NUMBER.findall(seen(found)), forms) for found, forms in twice)
    differ = [pair for pair in zip(shown, again, strict=True) if pair[0] != pair[1]]
    assert len(differ) > 10
    assert [(one, other) for one, other in differ if one not in forms or other not in others] == []


def test_what_is_left_out_is_counted(tmp_path):
    study = small_study(["random"], (0.0, 0.3), 1, 3)
    trials = play_study(study)
    broken = make_trial([0], p=0.3, trial=3, broken="reply")
    again = make_trial([0], p=0.0, trial=1, broken="model")
    kept = [trial for trial in trials if trial.key != broken.key]
    directory = write_study(tmp_path / "study", study, [again, *kept, broken])
    found = results(directory)
    assert {row.of: row.value for row in found.where("left_out")} == {"ended as error": 1, "replaced after an error": 1}
    assert sum(cell.trials for cell in found.cells) == 5
    assert "1 trials that ended as error" in " ".join(page_text(Page(found=found).text()))
