"""Studies side by side: the numbers are those of the records, the conclusion says no more, and the page is inert."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from builders import SOLUTION, make_trial, play_study, small_study, write_study
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binomtest, fisher_exact
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.proportion import confint_proportions_2indep

from lockprobe.interventions.conditions import read_condition
from lockprobe.report.compare import (
    Sample,
    compare_studies,
    conclusion,
    difference_table,
    study_differences,
    study_table,
    success_table,
    write_comparison,
)
from lockprobe.report.format import texts
from lockprobe.statistics.proportions import proportion
from lockprobe.studies.records.read_records import load

AGENTS = ("cognitive:careful", "random")
A = small_study(agents=AGENTS)
B = replace(A, agents=("cognitive:perseverant", "random"), conditions=small_study(p=(0.3, 0.0, 0.9)).conditions)
C = replace(B, seed=7)
NAMES = ["one/study", "two/study", "half"]


@pytest.fixture(scope="module")
def labs(tmp_path_factory):
    root = tmp_path_factory.mktemp("labs")
    half = play_study(C)[:20]
    return [
        write_study(root / "one" / "study", A),
        write_study(root / "two" / "study", B),
        write_study(root / "half", C, half),
    ]


@pytest.fixture(scope="module")
def found(labs):
    return compare_studies(labs)


@pytest.fixture(scope="module")
def page(found, tmp_path_factory):
    return write_comparison(found, tmp_path_factory.mktemp("page") / "compare.html").read_text("utf-8")


def sides(found):
    return [(one.condition, one.study) for one in found.samples]


def test_success_is_counted_from_the_records_of_the_conditions_that_two_studies_share(labs, found):
    counted = {}
    for name, directory in zip(NAMES, labs, strict=True):
        for trial in load(directory):
            condition = f"flip?p={trial.p:g}" if trial.p else "truth"
            if condition != "flip?p=0.6":
                counted.setdefault((condition, name, trial.agent), []).append(trial.solved)
    assert {(one.condition, one.study, one.agent): one.success for one in found.samples} == {
        key: proportion(sum(solved), len(solved)) for key, solved in counted.items()
    }
    told = {(row["condition"], row["study"], row["agent"]): row for row in found.plain()["success"]}
    assert {key: (row["solved"], row["trials"]) for key, row in told.items()} == {
        key: (sum(solved), len(solved)) for key, solved in counted.items()
    }
    for one in found.differences:  # luck is shared by seed
        studies = {one.first.study, one.second.study}
        assert one.paired == ("half" not in studies or len(studies) == 1)
    columns = ("name", "partial", "finished", "planned", "not_shared")
    assert [tuple(one[column] for column in columns) for one in found.plain()["studies"]] == [
        ("one/study", False, 48, 48, ["flip?p=0.6"]),
        ("two/study", False, 48, 48, []),
        ("half", True, 20, 48, []),
    ]


def test_every_condition_that_two_studies_share_is_compared_and_what_one_has_is_named(tmp_path):
    """Studies without a flip, with other names for the same conditions and in another order."""
    flipless = replace(A, agents=("cognitive:careful",), repetitions=1, trials=3)

    def lab(name, *conditions):
        return write_study(tmp_path / name, replace(flipless, conditions=tuple(conditions)))

    doses = [read_condition(f"tremble?p={p}") for p in (0.1, 0.2)]
    one = lab("a", read_condition("truth"), read_condition("drop?p=0.3", "mute"), *doses, read_condition("nudge", "x"))
    two = lab("b", *doses, read_condition("drop?p=0.3", "x"), read_condition("warn", "mute"), read_condition("truth"))
    found = compare_studies([one, two])
    shared = ["truth", "tremble?p=0.1", "tremble?p=0.2", "drop?p=0.3"]
    assert sides(found) == [(name, study) for name in shared for study in "ab"]
    rows = found.plain()["differences"]
    assert [row["condition"] for row in rows] == shared
    assert [row["family"] for row in rows] == ["flip rate", "tremble p", "tremble p", ""]
    assert all((row["paired"], row["value"], row["p_value"]) == (True, 0, 1) for row in rows)  # one seed
    assert [one["not_shared"] for one in found.studies] == [["nudge"], ["warn"]]


# The numbers: pairs only where luck is shared, and those of an independent implementation

RNG = np.random.default_rng(5)


@cache
def one_trial(solved, agent, number):
    return make_trial(
        SOLUTION if solved else (0,) * 20, agent=agent, trial=number, broken="model" if solved is None else None
    )


def trials(solved, agent="llm:a", start=1):
    return [one_trial(None if one is None else bool(one), agent, start + i) for i, one in enumerate(solved)]


def drawn(study, solved, luck=1, agent="llm:a", condition="truth", played=None):
    played = trials(solved, agent) if played is None else played
    return Sample(study=f"study {study}", agent=agent, condition=condition, luck=luck, trials=played)


def only(*samples):
    """What was found of the only two samples."""
    (one,) = study_differences(samples)
    return one.found


def random_outcomes(n=30):
    return RNG.random(n) < RNG.uniform(0.2, 0.8)


outcome = st.sampled_from([True, False, None])


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(outcome, outcome), min_size=1, max_size=30), st.randoms(use_true_random=False))
def test_one_seed_means_pairs_and_two_mean_independent_samples(solved, random):
    """None is a trial that was not played. Against scipy and statsmodels; which trial is which says nothing of two."""

    def of(study, column, luck):
        made = [one_trial(row[column], "llm:a", i) for i, row in enumerate(solved) if row[column] is not None]
        return drawn(study, (), luck, played=made)

    both = np.array([row for row in solved if None not in row], dtype=int).reshape(-1, 2)
    found = study_differences([of(0, 0, 1), of(1, 1, 1)])
    assert bool(found) == bool(len(both))
    for one in found:
        gained, lost = int(np.sum(both[:, 1] > both[:, 0])), int(np.sum(both[:, 1] < both[:, 0]))
        assert (one.paired, one.found.value) == (True, pytest.approx((gained - lost) / len(both)))
        assert one.found.exchange == pytest.approx(binomtest(gained, gained + lost).pvalue if gained + lost else 1)
        assert [one.found.first.count, one.found.second.count] == both.sum(axis=0).tolist()
    first, second = ([row[i] for row in solved if row[i] is not None] for i in (0, 1))
    found = study_differences([of(0, 0, 1), of(1, 1, 2)])
    assert bool(found) == bool(first and second)
    for one in found:
        low, high = confint_proportions_2indep(sum(second), len(second), sum(first), len(first), method="newcomb")
        table = [[sum(own), len(own) - sum(own)] for own in (second, first)]
        assert (one.paired, one.found.low, one.found.high) == (False, pytest.approx(low), pytest.approx(high))
        assert one.found.p_value == pytest.approx(fisher_exact(table).pvalue)
        assert only(drawn(0, random.sample(first, len(first))), drawn(1, second, luck=2)) == one.found


def test_p_values_are_corrected_within_a_kind_and_a_family_as_statsmodels_does():
    samples = [
        replace(drawn(study, random_outcomes(), agent=agent, condition=name), family=family)
        for name, family in (("truth", "flip rate"), ("nudge", ""), ("warn", ""))
        for study in range(3)
        for agent in ("llm:a", "random")
    ]
    samples = [replace(one, luck=7 if one.study == "study 2" else 1) for one in samples]
    found = study_differences(samples)
    kinds = [one.kind for one in found]
    assert [(kind, kinds.count(kind)) for kind in dict.fromkeys(kinds)] == [
        ("between", 9), ("between-baselines", 27), ("within-baselines", 9)
    ]  # fmt: skip
    for family in {one.family for one in found}:
        own = [one for one in found if one.family == family]
        alone = [only(one.first, one.second).p_value for one in own]
        expected = multipletests(alone, method="holm")[1]
        assert [one.found.p_value for one in own] == pytest.approx(list(expected))


@pytest.mark.parametrize("luck", [1, 2])
def test_broken_trials_that_could_turn_the_difference_leave_nothing_shown(luck):
    whole = only(drawn(0, [False] * 20), drawn(1, [True] * 10 + [False] * 10, luck=luck))
    few = only(drawn(0, [False] * 20), drawn(1, [True] * 10 + [False] * 9 + [None], luck=luck))
    turned = only(drawn(0, [False] * 8 + [None] * 12), drawn(1, [True] * 3 + [False] * 17, luck=luck))
    assert whole.detected()
    assert few.detected()
    assert few.p_value >= whole.p_value
    assert (turned.p_value, turned.detected()) == (1.0, False)
    assert (turned.first.count, turned.first.broken) == (0, 12)
    assert turned.first.high > 0.6  # all that broke may have been solved


def test_people_count_once_however_many_boxes_they_play():
    """The same trials, played by forty people or by eight: eight say less. They are never pairs."""

    def people(of, solved, number):
        return [
            make_trial(SOLUTION if one else (0,) * 20, agent=f"participant:{number}{i % of:02d}", trial=i + 1)
            for i, one in enumerate(solved)
        ]

    def groups(of, agent=False):
        first = drawn(0, (), played=people(of, [i % of < of // 4 for i in range(40)], "a"), agent="participant")
        second = people(of, [i % of < 3 * of // 4 for i in range(40)], "b")
        other = drawn(1, (), played=trials([t.solved for t in second]) if agent else second, agent="participant")
        return only(first, other)

    for agent in (False, True):
        many, few = groups(40, agent), groups(8, agent)
        assert many.value == few.value == 0.5
        assert few.high - few.low > many.high - many.low
        assert few.p_value > many.p_value


# The conclusion


def sample(study, solved, *, luck=1, condition="truth", family=""):
    trials = [make_trial(SOLUTION if i < solved else (0,) * 20, agent="llm:a", trial=i + 1) for i in range(20)]
    return Sample(study=study, agent="llm:a", condition=condition, family=family, luck=luck, trials=trials)


FLIPS = [sample(study, 10, luck=luck, family="flip rate") for luck, study in enumerate("ab")]
NUDGED = [sample(study, n, condition="nudge", luck=luck) for luck, (study, n) in enumerate((("a", 4), ("b", 11)))]
CLEAR = [sample(study, n, condition="nudge") for study, n in (("a", 1), ("b", 19))]


CONCLUSIONS = [
    ([], ["No two studies have a trial to compare under a condition that they share."]),
    (
        [sample("a", 9), sample("b", 11, luck=2), sample("c", 10, luck=3)],
        [
            "No difference between studies was detected in 3 comparisons, ",
            "P = 1, corrected for 3 differences of a family and 1 family; ",
        ],
    ),
    # a P value of 0.03 in its family: the sentence is about two, and the table about each
    (
        [*FLIPS, *NUDGED],
        [
            "No difference between studies was detected in 2 comparisons, ",
            ", corrected for 1 difference of a family and 2 families; ",
        ],
    ),
    (
        [*FLIPS, *CLEAR],
        ["1 of 2 differences between studies was detected, the clearest: llm:a in b against ", "random numbers)."],
    ),
]


@pytest.mark.parametrize(("samples", "parts"), CONCLUSIONS)
def test_the_conclusion_says_no_more_than_what_holds_in_all_families(samples, parts):
    said = conclusion(study_differences(samples))
    assert said.startswith(parts[0])
    assert said.endswith(parts[-1]) or len(parts) < 3
    assert all(part in said for part in parts)


# The page


def test_the_page_begins_with_the_sentence_holds_every_number_and_loads_nothing(found, page):
    text = re.sub(r"\s+", " ", re.sub(r"<[^>]*>", "", page))
    assert text.index(found.said) < text.index("Share solved of the trials")
    assert "20 of 48 trials of half" in text
    tables = (success_table(found), study_table(found), difference_table(found.differences))
    for cell in {cell for table in tables for row in texts([*table]) for cell in row} - {"of these, people's"}:
        assert cell in text
    assert page.count('<td class="pl">') == len(found.differences)
    assert "more differences: with baselines, and within one study" in text
    assert "default-src 'none'; img-src data:; style-src 'unsafe-inline'\"" in page
    assert "<script" not in page
    assert not re.findall(r'(?:src|href)="([^"]*)"', page)
