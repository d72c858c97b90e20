"""The page says one thing first, and is written alike: p is no letter of two meanings, captions are short."""

import re

import pytest
from builders import make_trial, modality_study, play_study, played_by_people, small_study, write_study
from report.page_text import page_text

from lockprobe.report.page import figures_of, parts_of, write_report
from lockprobe.report.rows import Results
from lockprobe.report.section import Figure, Table
from lockprobe.studies.options.studyfile import study

AGENTS = ["cognitive:perseverant", "human-inspired"]
MANY = {
    "p": [0, 0.2, 0.4],
    "condition": ["nudge", "drop?p=0.5", "nudge + flip?p=0.4", *(f"flip?p={p}&others=kept" for p in (0.2, 0.4))],
    "sweep": "tremble?p=0.1,0.3",
}


def a_subject():
    """An agent whose success rises, beside one that is blind, with a trial that broke."""
    rises = {0.0: 2, 0.3: 7, 0.6: 9}
    trials = [
        make_trial([3, 2, 1, 0] if i <= solved else [0] * 20, agent="llm:x", p=p, trial=i, claims=[None, "moved"])
        for p, solved in rises.items()
        for i in range(1, 11)
    ]
    trials[-1] = make_trial([0], agent="llm:x", p=0.6, trial=10, broken="reply")
    return small_study(("llm:x", "random"), tuple(rises), 1, 10), [
        *trials,
        *play_study(small_study(("random",), tuple(rises), 1, 10)),
    ]


def people():
    planned = small_study(("participant", "round-robin"), (0.0, 0.4), 1, 6)
    return planned, [*played_by_people(planned, 2), *play_study(small_study(("round-robin",), planned.p, 1, 6))]


@pytest.fixture(scope="module", params=["many conditions", "a subject", "people", "modalities"])
def written(request, tmp_path_factory, modal):
    """The results of a study and its page."""
    planned = {
        "many conditions": lambda: (study("flips", agent=AGENTS, trials=5, repetitions=1, **MANY), None),
        "a subject": a_subject,
        "people": people,
        "modalities": lambda: (modality_study(), modal),
    }[request.param]()
    directory = write_study(tmp_path_factory.mktemp("pages") / "study", *planned)
    write_report(directory)
    found = Results.model_validate_json((directory / "results.json").read_bytes())
    return found, (directory / "report.html").read_text("utf-8")


def test_at_most_700_words_stand_before_something_is_unfolded(written):
    _, page = written
    assert 100 < len(" ".join(page_text(folded(page))).split()) <= 700


def test_success_can_be_judged_against_chance_on_the_first_screen(written):
    found, page = written
    top = re.sub(r"<[^>]*>|\s+", " ", page.partition('id="trials"')[0])
    levels = [f"{100 * curve.value[-1]:.0f}" for curve in found.random_play]
    assert len(levels) == 2
    assert all(re.search(rf"chance [^.]*\b{level}\b", top) for level in levels)


def folded(page):
    """The page without what is folded away: of every part its heading and its answer."""
    while (
        inner := re.sub(
            r"(?s)<details[^>]*>\s*<summary>((?:(?!<details).)*?)</summary>(?:(?!<details).)*?</details>", r"\1", page
        )
    ) != page:
        page = inner
    return page


def test_a_table_or_figure_stands_on_the_page_once(written):
    found, page = written
    shown = [
        (one.block, one.name)
        for of in parts_of(found)
        for one in of.blocks
        if isinstance(one, Table | Figure) and one.name
    ]
    assert len(shown) > 5
    assert len(shown) == len({*shown})
    assert page.count("<img") >= sum(one.applies(found) for one in figures_of(parts_of(found)).values()) > 0


def test_no_interval_of_people_is_called_a_plain_wilson_interval(written):
    found, page = written
    if found.where("people"):
        said = [one for one in page_text(page) if "Wilson" in one]
        assert said
        assert not [one for one in said if "clustered by person" not in one and "Fisher" not in one]
