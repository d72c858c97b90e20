"""Detectors against the plainest statement of each rule, and the table against what is known of it beforehand."""

from itertools import pairwise, product
from math import log

import numpy as np
import pytest
from builders import make_trial
from scipy.stats import mannwhitneyu

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops import cover
from lockprobe.statistics.loops.chance import chance_level
from lockprobe.statistics.loops.detectors import (
    DETECTORS,
    as_table,
    comparison,
    flags,
    microseconds,
    score,
    share_flagged,
    threshold,
    verdicts,
)
from lockprobe.statistics.loops.detectors.catalogue import (
    autocorrelation,
    compression,
    coverage,
    determinism,
    phrase_length,
)
from lockprobe.statistics.loops.detectors.comparison import PLANTED, _auc, interrupted, plant, unplanted

NAMED = {detector.name: detector for detector in DETECTORS}
SCORES = [detector.name for detector in DETECTORS if not detector.rule]
SYMMETRIC = [
    "any-loop",
    "coverage",
    "openhands-like",
    "goose-like",
    "gemini-cli-like",
    "autocorrelation",
    "determinism",
]


def random_trials(trials=300, longest=24, actions=3):
    rng = np.random.default_rng(2)
    for length in rng.integers(0, longest + 1, trials):
        yield rng.integers(0, actions, length).tolist(), (rng.random(length) < 0.5).tolist()


@pytest.fixture(scope="module")
def rows():
    return {row.detector: row for row in comparison(400, seed=3)}


def test_identical_actions_in_a_row():
    for actions, moved in random_trials():
        text = "".join(map(str, actions))
        for name, times in (("goose-like", 4), ("gemini-cli-like", 5)):
            assert NAMED[name].score(actions, moved) == any(letter * times in text for letter in "012")


def stuck_in_a_window(steps):
    """The rule as an agent would meet it, looking back after every step."""
    last = [action for action, _ in steps[-3:]]
    if len(steps) >= 4 and len(set(steps[-4:])) == 1:
        return True
    if len(steps) >= 3 and len(set(last)) == 1 and not any(moved for _, moved in steps[-3:]):
        return True
    six = steps[-6:]
    return len(six) == 6 and len(set(six[::2])) == 1 and len(set(six[1::2])) == 1


def test_stuck_is_found_at_some_step():
    found = []
    for actions, moved in random_trials(1000, actions=2):
        steps = list(zip(actions, moved, strict=True))
        found.append(any(stuck_in_a_window(steps[:end]) for end in range(len(steps) + 1)))
        assert NAMED["openhands-like"].score(actions, moved) == found[-1], steps
    assert 100 < sum(found) < 900


@pytest.mark.parametrize(
    ("actions", "moved", "expected"),
    [
        ("AAAA", "1111", 1), ("AAA", "111", 0), ("AAA", "000", 1), ("AAAA", "1011", 0), ("ABABAB", "101010", 1),
        ("ABABAB", "101011", 0), ("ABABA", "00000", 0), ("AABAABAA", "00000000", 0), ("ABCABCABC", "000000000", 0),
    ],
)  # fmt: skip
def test_stuck_needs_equal_outcomes(actions, moved, expected):
    assert NAMED["openhands-like"].score(actions, [flag == "1" for flag in moved]) == expected


def test_determinism_on_the_recurrence_plot():
    for actions, moved in random_trials():
        n = len(actions)
        plot = {(i, j) for i, j in product(range(n), repeat=2) if i < j and actions[i] == actions[j]}
        paired = {(i, j) for i, j in plot if {(i - 1, j - 1), (i + 1, j + 1)} & plot}
        assert determinism(actions, moved) == pytest.approx(len(paired) / len(plot) if plot else 0)


def test_autocorrelation_by_lag():
    for actions, moved in random_trials():
        n = len(actions)
        shares = [np.mean([a == b for a, b in zip(actions, actions[k:], strict=False)]) for k in range(1, n // 2 + 1)]
        assert autocorrelation(actions, moved) == pytest.approx(max(shares, default=0))
    assert autocorrelation("ABCABCAB") == 1.0


def test_phrases_of_lempel_and_ziv():
    assert phrase_length("0001101001000101") == 16 / 6  # Kaspar and Schuster: 0 001 10 100 1000 101
    assert phrase_length("0" * 30) == 30 / 2
    assert phrase_length("ABCABCABC") == 9 / 4
    assert (phrase_length(""), phrase_length("A")) == (0, 1)
    rng = np.random.default_rng(4)
    n = 5_000  # a random sequence has n / log_k(n) phrases in the limit, from above
    assert phrase_length(rng.integers(0, 4, n).tolist()) == pytest.approx(log(n, 4), rel=0.1)


def test_compression_and_coverage():
    assert compression("ABCD" * 10) > compression("ABCD" * 5) > compression("ABDCACBDDBACDDBCBAAC")
    assert compression([]) == 0
    assert compression([(i, "x") for i in range(300)]) > 0
    for actions, moved in random_trials(50):
        assert coverage(actions, moved) == cover(actions).share


@pytest.mark.parametrize("detector", DETECTORS, ids=lambda detector: detector.name)
def test_what_does_not_matter(detector):
    names = {0: "up", 1: ("left", 1), 2: 7.5}
    for actions, moved in random_trials(100):
        found = detector.score(actions, moved)
        assert detector.score([names[action] for action in actions], moved) == found
        if detector.name in SYMMETRIC:
            assert detector.score(actions[::-1], moved[::-1]) == pytest.approx(found)
        if not detector.needs_outcome:
            assert detector.score(actions, ()) == found
        if detector.rule:
            assert found in {0.0, 1.0}


@pytest.mark.parametrize("name", SCORES)
def test_a_threshold_lets_five_percent_pass(name):
    for length, actions in ((6, 4), (13, 4), (20, 4), (20, 6), (40, 4)):
        rng = np.random.default_rng(9)
        trials = rng.integers(1, actions, (400, length)).cumsum(axis=1) % actions
        flagged = [flags(NAMED[name], trial, (), joints=actions) for trial in trials.tolist()]
        assert np.mean(flagged) < 0.05 + 4 * (0.05 * 0.95 / 400 + 0.05 * 0.95 / 500) ** 0.5
    assert flags(NAMED[name], "ABCD" * 5, ())


def test_scores_look_at_the_beginning_of_long_trials_and_rules_at_all():
    quiet = (np.random.default_rng(1).integers(1, 4, 100).cumsum() % 4).tolist()
    for name in SCORES:
        assert score(NAMED[name], [*quiet, *[0] * 200], ()) == score(NAMED[name], quiet, ())
    assert not flags(NAMED["gemini-cli-like"], quiet, ())
    assert flags(NAMED["gemini-cli-like"], [*quiet, *[0] * 200], ())
    with pytest.raises(BadValue, match="0 to 100"):
        threshold(NAMED["lz76"], 101)
    with pytest.raises(BadValue, match="actions"):
        threshold(NAMED["lz76"], 10, 1)


def test_area_under_the_curve():
    rng = np.random.default_rng(5)
    for kinds in (2, 5, 1000):
        positives, negatives = rng.integers(0, kinds, 40) / 7, rng.integers(0, kinds, 25) / 7
        pairs = [(a > b) + (a == b) / 2 for a, b in product(positives, negatives)]
        assert _auc(positives, negatives) == pytest.approx(np.mean(pairs))
        assert _auc(positives, negatives) == pytest.approx(mannwhitneyu(positives, negatives).statistic / 1000)


@pytest.mark.parametrize("kind", PLANTED, ids=lambda kind: kind.name)
def test_planted_loops_are_there(kind):
    made = plant(kind, 300, np.random.default_rng(6))
    starts = made.middle - kind.length // 2
    assert (starts >= 0).all()
    assert (starts + kind.length <= 20).all()
    assert len(set(starts.tolist())) == 20 - kind.length + 1
    wrong = 0
    for start, row, moved in zip(starts, made.actions.tolist(), made.moved.tolist(), strict=True):
        loop, outcomes = row[start : start + kind.length], moved[start : start + kind.length]
        outside = [*row[: start + 1], None, *row[start + kind.length - 1 :]]
        assert all(a != b for a, b in pairwise(outside))
        if kind.mutation:
            assert all(a != b for a, b in pairwise(row))
            wrong += sum(action != loop[i % kind.period] for i, action in enumerate(loop) if i >= kind.period)
        else:
            assert loop == loop[: kind.period] * kind.copies
            assert outcomes == outcomes[: kind.period] * kind.copies
            assert len(set(loop)) == kind.period
    if kind.mutation:
        differ = 1 - (0.9**2 + 0.1**2 / 2)  # a copy of a step differs from the first; two mutants may meet
        assert wrong / 300 / (kind.length - kind.period) == pytest.approx(differ, abs=0.03)


def test_random_trials_repeat_or_do_not():
    rng = np.random.default_rng(7)
    repeats = [np.mean(np.diff(unplanted(2000, rng, repeats=flag).actions) == 0) for flag in (False, True)]
    assert repeats == [0.0, pytest.approx(0.25, abs=0.01)]


@pytest.mark.parametrize("kind", PLANTED, ids=lambda kind: kind.name)
def test_an_interruption_stands_in_the_middle_of_the_loop(kind):
    made = plant(kind, 50, np.random.default_rng(8))
    rows, outcomes = interrupted(made, np.random.default_rng(8))
    for before, after, moved, middle in zip(made.actions.tolist(), rows, outcomes, made.middle, strict=True):
        assert len(after) == len(moved) == 22
        assert after[:middle] + after[middle + 2 :] == before
        assert all(a != b for a, b in pairwise(after[middle - 1 : middle + 3]))
        assert after[middle] != after[middle + 2]


def test_equal_seeds_equal_tables():
    assert comparison(20, seed=1) == comparison(20, seed=1)
    assert comparison(20, seed=1) != comparison(20, seed=2)
    with pytest.raises(BadValue, match="at least 20"):
        comparison(19)


def run_of(times, length=20, actions=4):
    """Exact probability that random actions hold one of them so many times in a row."""
    state = np.zeros(times)
    state[0] = 1.0
    for _ in range(length - 1):
        last = state[-1]
        state = np.array([(state[:-1].sum()) * (1 - 1 / actions), *(state[:-2] / actions), last + state[-2] / actions])
    return state[-1]


def test_false_positives_are_those_expected(rows):
    def near(found, probability):
        return abs(found - probability) < 4 * (probability * (1 - probability) / 400) ** 0.5

    assert near(rows["any-loop"].false_uniform, chance_level(20).probability)
    assert near(rows["any-loop"].false_no_repeat, chance_level(20, null="no-repeat").probability)
    short = ["".join(row) for row in product("AB", repeat=7)]
    assert run_of(3, 7, 2) == sum("AAA" in row or "BBB" in row for row in short) / 2**7
    assert near(rows["goose-like"].false_uniform, run_of(4))
    assert near(rows["gemini-cli-like"].false_uniform, run_of(5))
    assert (rows["goose-like"].false_no_repeat, rows["gemini-cli-like"].false_no_repeat) == (0, 0)
    assert all(rows[name].false_no_repeat < 0.11 for name in SCORES)


def test_what_the_table_is_read_for(rows):
    assert list(rows) == list(NAMED)
    runs, two, three, four, mutated, full = (kind.name for kind in PLANTED)
    for name in ("goose-like", "gemini-cli-like", "openhands-like"):
        assert rows[name].found[runs] == 1.0
        assert rows[name].auc[runs] > 0.97
        assert all(rows[name].auc[kind] == pytest.approx(0.5, abs=0.02) for kind in (three, four, full))
    assert rows["openhands-like"].found[two] == 1.0
    for kind in (runs, two, three, four, full):
        assert rows["any-loop"].found[kind] == 1.0
        assert rows["any-loop"].auc[kind] < 0.55
    best = max(rows.values(), key=lambda row: row.auc[four])
    assert best.detector in {"compression", "lz76"}
    for name in SCORES:
        assert rows[name].found[full] == 1.0
        assert rows[name].auc[four] > rows[name].auc[mutated]


def test_rules_have_the_area_of_their_two_rates(rows):
    for name in set(NAMED) - set(SCORES):
        for kind, found in rows[name].found.items():
            assert rows[name].auc[kind] == pytest.approx((1 + found - rows[name].false_no_repeat) / 2)


def test_what_changes_a_verdict_is_measured(rows):
    assert all(row.relabelled == 1.0 for row in rows.values())
    assert all(rows[name].reversed == 1.0 for name in SYMMETRIC)
    assert rows["goose-like"].interrupted == 0.0
    assert rows["coverage"].interrupted > rows["autocorrelation"].interrupted > rows["lz76"].interrupted


def test_the_table_as_text(rows):
    lines = as_table(list(rows.values())).splitlines()
    assert len(lines) == 2 + len(DETECTORS)
    assert len({line.count("|") for line in lines}) == 1
    row = rows["lz76"]
    assert f"| lz76 | {row.false_uniform:.3f} | {row.false_no_repeat:.3f} | {row.auc['A x6']:.2f} [" in lines[-2]
    timed = as_table(list(rows.values()), {detector.name: 12.6 for detector in DETECTORS})
    assert all(line.endswith(" 13 |") for line in timed.splitlines()[2:])
    assert microseconds(NAMED["any-loop"], 20) > 0


def test_share_of_a_conditions_trials():
    trials = [make_trial([0] * 6), make_trial([0, 1, 2, 1, 0, 2]), make_trial([0] * 6, broken="model")]
    found = share_flagged(trials)
    assert list(found) == list(NAMED)
    assert (found["goose-like"], found["openhands-like"], found["any-loop"]) == (0.5, 0.5, 0.5)
    told = make_trial([0] * 3, false_at=[2])
    assert share_flagged([make_trial([0] * 3), told], [NAMED["openhands-like"]]) == {"openhands-like": 0.5}
    assert share_flagged(trials[2:]) == {}


@pytest.mark.parametrize("detector", [one for one in DETECTORS if not one.rule], ids=lambda one: one.name)
def test_the_table_of_thresholds_holds_what_is_calibrated(detector):
    """Else: python scripts/make_detector_thresholds.py."""
    assert [threshold(detector, n) for n in range(21)] == [verdicts.calibrated(detector, n, 4) for n in range(21)]
    assert threshold(detector, 21) == verdicts.calibrated(detector, 21, 4)
    assert len(verdicts._known()[detector.name]) == 21
