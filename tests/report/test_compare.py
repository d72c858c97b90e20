"""Studies side by side: the numbers are those of the records, the conclusion says no more, and the page is inert."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from builders import SOLUTION, make_trial, play_study, small_study, study_of, write_study
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import fisher_exact

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, UserMistake
from lockprobe.interventions.conditions import read_condition
from lockprobe.report.compare import (
    TABLES,
    Sample,
    check_same_task,
    compare_studies,
    families,
    shared,
    study_rows,
    write_comparison,
)
from lockprobe.report.format import texts
from lockprobe.statistics.pairs import paired
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


def of(rows, quantity="success_difference"):
    return [row for row in rows if row.quantity == quantity]


def test_success_is_counted_from_the_records_of_the_conditions_that_two_studies_share(labs, found):
    counted = {}
    for name, directory in zip(NAMES, labs, strict=True):
        for trial in load(directory):
            condition = f"flip?p={trial.p:g}" if trial.p else "truth"
            if condition != "flip?p=0.6":
                counted.setdefault((condition, name, trial.agent), []).append(trial.solved)
    shares = {key: proportion(sum(solved), len(solved)) for key, solved in counted.items()}
    told = {(row.condition, row.study, row.agent): row for row in of(found.rows, "success")}
    assert {key: (row.count, row.n, row.low, row.high) for key, row in told.items()} == {
        key: (one.count, one.n, one.low, one.high) for key, one in shares.items()
    }
    for row in of(found.rows):  # luck is shared by seed; baselines stand in their own reports
        assert row.test.startswith("McNemar") == ("half" not in (row.study, row.versus_study))
        assert "random" not in (row.agent, row.versus)
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
    sides = [(row.condition, row.study) for row in of(found.rows, "success")]
    assert sides == [(name, study) for name in shared for study in "ab"]
    rows = of(found.rows)
    assert [row.condition for row in rows] == shared
    assert [(row.family, row.corrected_for) for row in rows] == [
        ("flip rate", 1), ("tremble p", 2), ("tremble p", 2), ("", 1)
    ]  # fmt: skip
    assert all((row.test, row.value, row.p_value) == ("McNemar, and interval", 0, 1) for row in rows)  # one seed
    assert [one["not_shared"] for one in found.studies] == [["nudge"], ["warn"]]


# Which studies can be compared: the same task, and a condition in common, whatever it is called.

FLIPS = small_study()
ONE, OTHER = Path("a"), Path("b")
SEVERAL = replace(FLIPS, boxes=(FLIPS.box, box("fork"), box("reset")))


@pytest.mark.parametrize(
    ("study", "change", "why"),
    [
        (SEVERAL, {"boxes": (FLIPS.box,)}, "box is chain-4, not chain-4, fork, reset"),
        (SEVERAL, {"seed": 9}, "seed is 9, not 1"),  # several boxes are compared in pairs of equal luck
        (FLIPS, {"boxes": (box("chain-5"),)}, "box is chain-5, not chain-4"),
        (FLIPS, {"boxes": (replace(box("chain-5"), name="chain-4"),)}, "box is chain-4, not another chain-4"),
        (FLIPS, {"max_steps": 30}, "max_steps is 30, not 20"),
        (FLIPS, {"plant": "fast-twin"}, "plant is fast-twin, not symbolic"),
        (FLIPS, {"layout": "shuffled"}, "layout is shuffled, not fixed"),
        (FLIPS, {"assessment": False}, "assessment is False, not True"),
    ],
)
def test_another_task_is_refused_with_the_reason(study, change, why):
    check_same_task({ONE: study, OTHER: replace(study, agents=("round-robin",))})
    with pytest.raises(BadFile, match=rf"^b: it cannot be compared with a: {why}$"):
        check_same_task({ONE: study, OTHER: replace(study, **change)})


def test_one_study_and_one_without_a_condition_in_common_are_refused_with_the_reason(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    flips = study_of((0.1, 0.9), name="flips", agents=("random",), boxes=(box("chain-4"),))
    sticky = study_of((0.3,), "integrated", name="flips", agents=("random",), boxes=(box("chain-4"),))
    for name, study in {"a": FLIPS, "b": flips, "c": sticky, "d": FLIPS}.items():
        write_study(tmp_path / name, study, [])
    for asked, said in (
        ("a", "two or more"),
        ("ab", r"^a: it shares no condition .*: it has truth, flip\?p=0\.3 and flip\?p=0\.6; they"),
        ("ac", r"they have flip\?p=0\.3&others=kept$"),
        ("adb", "^b: it shares no condition"),
    ):
        with pytest.raises(UserMistake, match=said):
            compare_studies([*map(Path, asked)])


def test_a_prompt_belongs_to_the_agent(tmp_path):
    file = tmp_path / "curt.txt"
    file.write_text("{joints} {target} {reply}")
    conditions = map(read_condition, ("truth", f"prompt?file={file}", f"prompt?file={file} + nudge"))
    found = [(acting.label, prompt) for acting, prompt in shared(replace(FLIPS, conditions=(*conditions,))).values()]
    assert found == [("truth", ""), ("truth", str(file)), ("nudge", str(file))]


def test_families_are_flip_rates_with_the_truth_every_other_axis_and_all_others():
    specs = ("tremble?p=0.1", "nudge", "truth", "flip?p=0.4", "tremble?p=0.2", "drop?p=0.3")
    study = replace(FLIPS, conditions=tuple(map(read_condition, specs)))
    found = " ".join(
        f"{name}:{family}" for name, family in families(acting for acting, _ in shared(study).values()).items()
    )
    doses = "tremble?p=0.1:tremble p tremble?p=0.2:tremble p"
    assert found == f"truth:flip rate flip?p=0.4:flip rate {doses} nudge: drop?p=0.3:"


# The numbers: pairs only where luck is shared, and those of an independent implementation


@cache
def one_trial(solved, agent, number):
    return make_trial(
        SOLUTION if solved else (0,) * 20, agent=agent, trial=number, broken="model" if solved is None else None
    )


def trials(solved, agent="llm:a"):
    return [one_trial(None if one is None else bool(one), agent, i) for i, one in enumerate(solved, 1)]


def drawn(study, solved, luck=1, agent="llm:a", condition="truth", played=None, family=""):
    played = trials(solved, agent) if played is None else played
    return Sample(f"study {study}", agent, condition, luck, played, family)


def only(*samples):
    """The difference of the only two samples, and what the second and the first solved."""
    return study_rows(samples)[4:]


outcome = st.sampled_from([True, False, None])


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(outcome, outcome), min_size=1, max_size=30), st.randoms(use_true_random=False))
def test_one_seed_means_pairs_and_two_mean_independent_samples(solved, random):
    """None is a trial that was not played. Against scipy and statsmodels; which trial is which says nothing of two."""
    from statsmodels.stats.proportion import confint_proportions_2indep

    def of(study, column, luck):
        made = [one_trial(row[column], "llm:a", i) for i, row in enumerate(solved) if row[column] is not None]
        return drawn(study, (), luck, played=made)

    columns = [[row[i] for row in solved if row[i] is not None] for i in (0, 1)]
    if not all(columns):
        return
    both = np.array([row for row in solved if None not in row], dtype=bool).reshape(-1, 2)
    found = only(of(0, 0, 1), of(1, 1, 1))
    assert bool(found) == bool(len(both))
    if found:
        row, after, before = found
        expected = paired(*both.T)
        assert (row.value, row.low, row.high) == (expected.value, expected.low, expected.high)
        assert row.p_value == expected.p_value
        assert [before.count, after.count] == both.sum(axis=0).tolist()
    first, second = columns
    row, *_ = only(of(0, 0, 1), of(1, 1, 2))
    low, high = confint_proportions_2indep(sum(second), len(second), sum(first), len(first), method="newcomb")
    table = [[sum(own), len(own) - sum(own)] for own in (second, first)]
    assert (row.test, row.low, row.high) == ("Fisher", pytest.approx(low), pytest.approx(high))
    assert row.p_value == pytest.approx(fisher_exact(table).pvalue)
    assert only(drawn(0, random.sample(first, len(first))), drawn(1, second, luck=2))[0] == row


def test_p_values_are_corrected_within_a_family_as_statsmodels_does():
    from statsmodels.stats.multitest import multipletests

    rng = np.random.default_rng(5)
    samples = [
        drawn(study, rng.random(30) < rng.uniform(0.2, 0.8), 7 if study == 2 else 1, agent, name, family=family)
        for name, family in (("truth", "flip rate"), ("nudge", ""), ("warn", ""))
        for study in range(3)
        for agent in ("llm:a", "llm:b", "random")
    ]
    rows, known = of(study_rows(samples)), {(one.study, one.agent, one.condition): one for one in samples}
    assert len(rows) == 3 * 3 * 4  # conditions, pairs of studies, and of the agents of both
    for family, many in (("flip rate", 12), ("", 24)):
        own = [row for row in rows if row.family == family]
        alone = [
            only(*(known[study, agent, row.condition] for study, agent in sides))[0].p_value
            for row in own
            for sides in [((row.versus_study, row.versus), (row.study, row.agent))]
        ]
        assert [row.p_value for row in own] == pytest.approx(list(multipletests(alone, method="holm")[1]))
        assert {row.corrected_for for row in own} == {many}


@pytest.mark.parametrize("luck", [1, 2])
def test_broken_trials_that_could_turn_the_difference_leave_nothing_shown(luck):
    whole, *_ = only(drawn(0, [False] * 20), drawn(1, [True] * 10 + [False] * 10, luck=luck))
    few, *_ = only(drawn(0, [False] * 20), drawn(1, [True] * 10 + [False] * 9 + [None], luck=luck))
    samples = drawn(0, [False] * 8 + [None] * 12), drawn(1, [True] * 3 + [False] * 17, luck=luck)
    share, broken, _, _, turned, *_ = study_rows(samples)
    assert whole.detected
    assert few.detected
    assert few.p_value >= whole.p_value
    assert (turned.p_value, turned.detected, turned.note) == (1.0, False, "whatever became of broken trials")
    assert (share.count, broken.value) == (0, 12)
    assert share.high > 0.6  # all that broke may have been solved


def test_people_count_once_however_many_boxes_they_play():
    """The same trials, played by forty people or by eight: eight say less. They are never pairs."""

    def people(of, solved, number):
        return [
            make_trial(SOLUTION if one else (0,) * 20, agent=f"participant:{number}{i % of:02d}", trial=i + 1)
            for i, one in enumerate(solved)
        ]

    def groups(of, agent=False):
        first = drawn(0, (), played=people(of, [i % of < of // 4 for i in range(40)], "a"))
        second = people(of, [i % of < 3 * of // 4 for i in range(40)], "b")
        return only(first, drawn(1, (), played=trials([t.solved for t in second]) if agent else second))[0]

    for agent in (False, True):
        many, few = groups(40, agent), groups(8, agent)
        assert many.value == few.value == 0.5
        assert few.high - few.low > many.high - many.low
        assert few.p_value > many.p_value


def test_the_page_begins_with_the_sentence_holds_every_number_and_loads_nothing(found, tmp_path):
    page = write_comparison(found, tmp_path / "compare.html").read_text("utf-8")
    text = re.sub(r"\s+", " ", re.sub(r"<[^>]*>", "", page).replace("&nbsp;", " "))
    rows = of(found.rows)
    assert found.said == f"{sum(row.detected for row in rows)} of {len(rows)} differences between studies detected."
    assert text.index(found.said) < text.index("Share solved of the trials")
    assert "20 of 48 trials of half" in text
    cells = {cell for lines in TABLES.values() for row in texts([*lines(found)]) for cell in row}
    assert all(cell in text for cell in cells - {"of these, people's"})
    assert page.count('<td class="pl">') == len(rows)
    assert "default-src 'none'; img-src data:; style-src 'unsafe-inline'\"" in page
    assert "<script" not in page
    assert not re.findall(r'(?:src|href)="([^"]*)"', page)
