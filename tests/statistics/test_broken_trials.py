"""Trials that broke: bounds of shares, curves and differences, and nothing concluded that hangs on what became of them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from builders import SOLUTION, make_trial, small_study, write_study
from hypothesis import given, settings
from hypothesis import strategies as st
from net import unpacked
from reported import found_in
from solved import columns

from lockprobe.cli.result import found as said_of
from lockprobe.report.opened import open_study
from lockprobe.report.questions.claims import judged, paper_claims
from lockprobe.report.results import results
from lockprobe.statistics.broken_trials import worst
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.differences import each_difference, few_broke_until
from lockprobe.statistics.every_look import Numbers, at_every_look, share_at_every_look
from lockprobe.statistics.how_soon import Hazard, success_curve
from lockprobe.statistics.outcomes import BlockOrder, outcomes
from lockprobe.statistics.pairs import paired
from lockprobe.statistics.proportions import proportion
from lockprobe.trial.record import TrialError

AGENT = "llm:local"


def at(p, solved, failed, broken):
    """Trials at one p: so many solved, failed and broken, in an order of luck that differs between values of p."""
    kinds = [SOLUTION] * solved + [(int(10 * p) % 4, *(0,) * 19)] * failed + [None] * broken
    order = np.random.default_rng(int(100 * p)).permutation(len(kinds))
    return [
        make_trial((0, 1), agent=AGENT, p=p, trial=i, broken="reply")
        if kinds[place] is None
        else make_trial(kinds[place], agent=AGENT, p=p, trial=i)
        for i, place in enumerate(order, 1)
    ]


def played(solved, broke, length=None):
    """The trials of one condition."""
    ended = np.asarray(solved, bool) & ~np.asarray(broke, bool)
    every = columns(
        np.zeros(len(ended)), np.arange(len(ended)) + 1, length=20 if length is None else length, solved=ended
    )
    return replace(every, broke=np.asarray(broke, bool))


def compared(groups):
    """Success of the second group less that of the first, with its bounds."""
    ((_, found),) = each_difference(groups)
    return found


@pytest.mark.parametrize(
    ("solved", "n", "broken"), [(6, 6, 24), (0, 10, 5), (10, 10, 5), (7, 20, 10), (3, 29, 1), (0, 0, 8)]
)
def test_a_share_has_the_bounds_of_horowitz_and_manski_with_wilsons_ends(solved, n, broken):
    found = share_of([1.0] * solved + [math.nan] * broken + [0.0] * (n - solved), (), ())
    begun = n + broken
    assert (found.count, found.n, found.broken) == (solved, n, broken)
    assert found.bounds == (solved / begun, (solved + broken) / begun)
    assert found.low == proportion(solved, begun).low
    assert found.high == proportion(solved + broken, begun).high


def test_a_curve_has_bounds_from_the_step_in_which_trials_broke():
    """Of ten, four solve in step 4, three never, and three break in step 3."""
    trials = at(0.0, 4, 3, 3)
    curve = success_curve(outcomes(trials))
    known = {2: (0, 0), 3: (0, 3), 4: (4, 7), 20: (4, 7)}
    assert curve.n == 10
    for step, (least, most) in known.items():
        ends = proportion(least, 10).low, proportion(most, 10).high
        assert curve.share[step] == pytest.approx((least + most) / 20)
        assert (curve.low[step], curve.high[step]) == pytest.approx(ends)


TRIALS = st.lists(st.tuples(*[st.booleans()] * 4), min_size=2, max_size=25).filter(
    lambda trials: not all(first or second for *_, first, second in trials)
)


@settings(max_examples=40, deadline=None)
@given(TRIALS)
def test_whatever_became_of_them_lies_within_the_bounds(trials):
    """Each trial with how it would have ended, and whether it broke before: the whole truth against what is known."""
    table = np.array(trials)
    solved, broke = table[:, :2], table[:, 2:]
    for side in (0, 1):
        known = share_of(np.where(broke[:, side], np.nan, solved[:, side]), (), ())
        truth = proportion(int(solved[:, side].sum()), len(solved))
        assert known.bounds[0] <= truth.value <= known.bounds[1]
        assert known.low <= truth.low
        assert truth.high <= known.high
    found = compared([played(solved[:, side], broke[:, side]) for side in (0, 1)])
    truth = paired(solved[:, 0], solved[:, 1])
    least, most = found.bounds or (truth.value, truth.value)
    assert least - 1e-12 <= truth.value <= most + 1e-12
    assert found.low <= found.value <= found.high
    if found.p_value < 0.05:
        assert np.sign(found.value) == np.sign(truth.value)
        assert truth.p_value < 0.05


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=2, max_size=30))
def test_opposed_ends_are_the_paired_differences_of_the_two_completed_studies(trials):
    """Of the first group the even trials broke, of the second every third: computed once more by hand."""
    solved = np.array(trials)
    broke = np.arange(len(solved))[:, None] % [2, 3] == [1, 2]
    groups = [played(solved[:, side], broke[:, side]) for side in (0, 1)]
    low = paired(*np.where(broke, [True, False], solved).T)
    high = paired(*np.where(broke, [False, True], solved).T)
    found = compared(groups)
    if broke.any():
        assert found.bounds == (low.value, high.value)
        assert (found.low, found.high) == (min(low.low, high.low, found.value), max(low.high, high.high, found.value))
        signs = {np.sign(one) for one in (low.value, high.value, found.value)}
        ends = [low.p_value, high.p_value]
        assert found.p_value == (max(ends) if len(signs) == 1 else 1.0)


@pytest.mark.parametrize(
    ("tests", "expected"),
    [
        ([(2.0, 0.2)], 0.2),  # no trial broke
        ([(2.0, None)], None),
        ([(2.0, 0.01), (1.0, 0.02), (3.0, 0.03)], 0.03),
        ([(2.0, 0.04), (1.0, 0.02), (3.0, 0.03)], 0.03),  # the value itself is between both ends
        ([(2.0, 0.01), (1.0, 0.02), (-1.0, 0.03)], 1.0),
        ([(-2.0, 0.01), (1.0, 0.02), (1.0, 0.03)], 1.0),
        ([(2.0, 0.01), (1.0, None), (1.0, 0.03)], None),
        ([(2.0, None), (1.0, 0.02), (1.0, 0.03)], None),
    ],
)
def test_a_test_has_the_larger_p_value_of_both_ends_if_all_point_one_way(tests, expected):
    found, *ends = (Hazard(total=total, p_value=p) for total, p in tests)
    assert worst(found, *ends) == replace(found, p_value=expected)


def test_at_every_look_intervals_and_the_whole_course_are_those_of_both_ends():
    """A tenth of sixty blocks broke under each condition: computed once more with these filled by hand."""
    rng, order = np.random.default_rng(5), BlockOrder(plans=((1, 60),))
    solved = rng.random((60, 2)) < [0.2, 0.8]
    broke = rng.random((60, 2)) < 0.1
    found = compared([replace(played(solved[:, side], broke[:, side]), order=order) for side in (0, 1)])
    filled = (np.where(broke, ends, solved).astype(float) for ends in ([True, False], [False, True]))
    low, high = (at_every_look([Numbers(values=one[:, 1] - one[:, 0], block=np.arange(60))])[0] for one in filled)
    assert (found.low, found.high) == (min(low.low, high.low, found.value), max(low.high, high.high, found.value))
    assert found.p_value == max(low.p_value, high.p_value) < 0.05
    assert (found.course.low, found.course.high, found.course.p_value) == (found.low, found.high, found.p_value)
    assert found.course.lows.tolist() == np.minimum(low.lows, high.lows).tolist()
    assert found.course.highs.tolist() == np.maximum(low.highs, high.highs).tolist()
    share = share_at_every_look(np.where(broke[:, 0], np.nan, solved[:, 0]))
    failed, opened = (share_at_every_look(np.where(broke[:, 0], end, solved[:, 0])) for end in (0, 1))
    assert (share.low, share.high, share.broken) == (failed.low, opened.high, broke[:, 0].sum())


def test_a_claim_of_the_paper_is_not_held_against_the_trials_that_remain(tmp_path):
    """As many trials as in the paper are solved, 7 and 20 of 30; at 0.4 all ten others broke, so that 20 of 20 are."""
    trials = [
        *(make_trial(SOLUTION if i <= 7 else (0,) * 20, agent="llm:a", trial=i) for i in range(1, 31)),
        *(make_trial(SOLUTION, agent="llm:a", p=0.4, trial=i) for i in range(1, 21)),
        *(make_trial((0,) * 18, agent="llm:a", p=0.4, trial=i, broken="reply") for i in range(21, 31)),
    ]
    found = found_in(tmp_path, small_study(["llm:a"], (0.0, 0.4), 1, 30), trials)
    (claim,) = (one for one in paper_claims() if one.measure == "ratio")
    assert [(one.verdict, one.p_value) for one in judged(found, claim)] == [("compatible", 1.0)]


WORLDS = {
    "failures break": lambda solved: ~solved & [False, True],
    "successes break": lambda solved: solved & [False, True],
    "opposed": lambda solved: np.where([True, False], ~solved, solved),
    "failures break everywhere": lambda solved: ~solved,
}
"""Which trials can break, by whether they would be solved under each of two conditions; a fifth of these does."""

TRUTH = 0.5


@pytest.mark.parametrize("studies", [80, pytest.param(2000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("world", WORLDS)
def test_shares_cover_the_truth_and_no_effect_is_found_where_there_is_none(world, studies):
    n, rng, covered, effects = 30, np.random.default_rng(7), [], []
    for _ in range(studies):
        own, alike = rng.random((n, 2)), rng.random(n) < 0.5
        solved = np.where(alike[:, None], own[:, :1], own) < TRUTH
        broke = WORLDS[world](solved) & (rng.random((n, 2)) < 0.2)
        for side in (0, 1):
            share = share_of(np.where(broke[:, side], np.nan, solved[:, side]), (), ())
            covered.append(share.low <= TRUTH <= share.high)
        effects.append(compared([played(solved[:, side], broke[:, side]) for side in (0, 1)]).p_value < 0.05)
    error = 3 / math.sqrt(studies)
    assert np.mean(covered) >= 0.94 - error * math.sqrt(0.94 * 0.06)
    assert np.mean(effects) <= 0.05 + error * math.sqrt(0.05 * 0.95)


@pytest.mark.parametrize(
    ("broke_in", "n", "step"),
    [([], 20, 20), ([9], 20, 20), ([9, 12], 20, 11), ([3, 4, 4, 12], 60, 11), ([1, 1], 20, 0), ([5], 10, 4)],
)
def test_the_last_step_with_few_breaks(broke_in, n, step):
    broke = np.arange(n) < len(broke_in)
    length = np.array([one - 1 for one in broke_in] + [20] * (n - len(broke_in)))
    groups = [played(np.zeros(n), broke, length), played(np.zeros(n), np.zeros(n, bool))]
    assert few_broke_until(groups) == step


def test_a_server_that_refuses_long_trials_leaves_no_share_that_misses_the_truth(tmp_path):
    """Eighteen trials of an agent that solves 39.3 %; every one that comes to step 19 breaks there, and is owed."""
    ends = [SOLUTION, (0,) * 18, (0,) * 18] * 6
    trials = [
        make_trial(joints, agent="llm:a", trial=i, broken=None if joints is SOLUTION else "model")
        for i, joints in enumerate(ends, 1)
    ]
    found = found_in(tmp_path, small_study(["llm:a"], (0.0,), 1, 18), trials)
    share = found.one("success", agent="llm:a", of="")
    assert (share.count, share.n) == (6, 6)
    assert share.low <= 6 / 18 <= 0.393 <= share.high
    assert [found.one("success", agent="llm:a", of=of).value for of in ("at least", "at most")] == [6 / 18, 1.0]
    assert found.answer.endswith("; 12 more broke, so of all trials it is between 33 % and 100 %.")
    (told,) = [line for line in said_of(found, tmp_path)[0] if line.startswith("  llm:a: ")]
    assert "12 of 18 trials broke, 6 of the other 6 opened the box" in told
    assert "half of the breaks came at step 19" in told


@pytest.mark.parametrize("boundary", ["reply", "model"])
def test_whatever_breaks_every_number_is_there_and_within_its_interval(tmp_path, boundary):
    """Every third trial of a kept study breaks, and all of some conditions; for good (reply), or owed again."""
    whole = open_study(unpacked("one-rate-broken" if boundary == "reply" else "crossed", tmp_path))
    rng = np.random.default_rng(3)
    chance = {
        cell: rng.choice([0.1, 0.3, 1.0]) for cell in sorted({(one.group, one.condition) for one in whole.trials})
    }

    def breaks(trial):
        end = int(rng.integers(0, len(trial.steps)))
        error = TrialError(boundary="model", message="it broke", step=end + 1)
        return replace(trial, steps=trial.steps[:end], ending="error", error=error, changed={}, changed_steps=0)

    trials = [
        breaks(one) if rng.random() < chance[one.group, one.condition] else one for one in whole.records(whole.trials)
    ]
    found = results(write_study(tmp_path / "broken", whole.study, trials))
    assert found.progress.every_look == ""
    assert found.sections_left_out == ()
    for row in found.rows:
        if None not in (row.value, row.low, row.high):
            assert row.low <= row.value <= row.high
        if (
            row.quantity == "success_difference"
            and row.p_value is not None
            and row.p_value < 0.05
            and row.low is not None
        ):
            assert row.low > 0 or row.high < 0
