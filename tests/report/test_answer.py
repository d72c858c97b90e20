"""The answer in sentences: what the tests say and no more, for one agent and for thirty."""

import re
from types import SimpleNamespace

import pytest
from builders import SOLUTION, make_trial, small_study
from reported import found_in
from scipy.stats import binom

from lockprobe.report.answer import answer, chance_said, needed_said
from lockprobe.report.rows.primary import Line, primary_lines

UNSOLVED = (0,) * 20


def study_in(directory, n=40, **courses):
    """Agents of which so many of n trials are solved at each flip rate."""
    rates = sorted({p for shares in courses.values() for p in shares})
    trials = [
        make_trial(SOLUTION if i < count else (int(10 * p) % 4, *UNSOLVED[1:]), agent=f"llm:{name}", p=p, trial=i + 1)
        for name, shares in courses.items()
        for p, count in shares.items()
        for i in range(n)
    ]
    return found_in(directory, small_study([f"llm:{name}" for name in courses], rates, 1, n), trials)


@pytest.mark.parametrize(
    ("courses", "said"),
    [
        ({"a": {0: 5}}, "llm:a solved 12 % of 40 trials."),
        ({"a": {0: 5}, "b": {0: 30}}, "Of 2 agents llm:b solved the most: 75 % of 40 trials."),
        ({"a": {0: 5}, "b": {0: 5}}, "The 2 agents solved the same share: 12 % of 40 trials."),
        ({"a": {0: 5, 0.4: 30}}, "False reports raise the success of llm:a."),
        (
            {"a": {0: 5, 0.4: 30}, "b": {0: 30, 0.4: 5}},
            "False reports raise the success of llm:a and lower that of llm:b.",
        ),
        (
            {"a": {0: 5, 0.4: 30}, "b": {0: 20, 0.4: 21}},
            "False reports raise the success of llm:a; no effect on that of llm:b was detected.",
        ),
        (
            {"a": {0: 20, 0.4: 21}, "b": {0: 20, 0.4: 20}},
            "No effect of false reports on the success of llm:a and llm:b was detected; changes of up to",
        ),
    ],
)
def test_the_answer_says_what_the_tests_say(tmp_path, courses, said):
    found = study_in(tmp_path, **courses)
    assert found.answer == answer(found)
    assert found.answer.startswith(said)
    assert len(found.answer.split()) <= 30


@pytest.mark.parametrize("solved", [0, 18])
def test_eighteen_pairs_that_all_agree_leave_the_question_open(tmp_path, solved):
    """A change of 10 points leaves 18 of 18 pairs alike in 15 % of studies."""
    found = study_in(tmp_path, 18, a={0: solved, 0.4: solved})
    assert re.search(r"changes of up to \d\d points are not excluded", found.answer)


def test_trials_needed_shrink_the_interval_to_ten_points(tmp_path):
    found = study_in(tmp_path, 16, a={0: 5, 0.4: 8})
    (line,) = primary_lines(found)
    half = (line.change.high - line.change.low) / 2
    (needed,) = map(int, re.findall(r"about (\d+) trials", needed_said([line])))
    assert 16 * (half / 0.1) ** 2 <= needed <= 1.1 * 16 * (half / 0.1) ** 2
    assert needed_said(primary_lines(study_in(tmp_path / "clear", a={0: 5, 0.4: 30}))) == ""


@pytest.mark.parametrize("trials", [1, 2, 3, 4, 6, 12, 17, 40])
@pytest.mark.parametrize("chance", [0.02, 0.1, 0.3, 0.69, 0.9, 0.99])
@pytest.mark.parametrize("agents", [1, 2, 10])
def test_agents_at_chance_are_seldom_said_to_be_below_or_above_it(trials, chance, agents):
    """Whatever the number of trials: one trial in ten that fails at a chance of 90 % shows nothing."""
    by_chance, below, above = binom(trials, chance), 0.0, 0.0
    for count in range(trials + 1):
        row = SimpleNamespace(n=trials, count=count, low=None, high=None)
        found = SimpleNamespace(
            get=lambda quantity, row=row, **of: SimpleNamespace(value=chance) if of.get("of") == "no-repeat" else row,
            where=lambda quantity, **of: [],
            progress=SimpleNamespace(every_look=""),
        )
        lines = [
            Line(
                agent=f"llm:{i}", label=f"llm:{i}", modality="symbolic", conditions=("truth",),
                first=row, control="told the truth",
            )
            for i in range(agents)
        ]  # fmt: skip
        said = chance_said(found, lines)
        below += by_chance.pmf(count) * ("solved fewer" in said)
        above += by_chance.pmf(count) * (not said)
    assert 1 - (1 - below) ** agents <= 0.05
    assert 1 - (1 - above) ** agents <= 0.05


def test_the_answer_is_corrected_for_many_agents(tmp_path):
    """One of ten agents differs by chance as one in a hundred would: of ten that is nothing."""
    alone = study_in(tmp_path / "one", a={0: 12, 0.4: 20})
    assert alone.answer == "False reports raise the success of llm:a."
    many = study_in(tmp_path / "ten", a={0: 12, 0.4: 20}, **{name: {0: 20, 0.4: 20} for name in "bcdefghij"})
    assert many.answer.startswith("No effect of false reports on the success of 10 agents was detected")
