"""Moments of observers: equal beliefs are one moment, and attempts are worth the same one by one and together."""

import pytest
from builders import play_study, small_study

from lockprobe.boxes.beliefs.planning import expected_steps, information
from lockprobe.boxes.beliefs.posterior import ReportedAttempt, begin, entropy, noise_model, opened, update
from lockprobe.boxes.beliefs.structures import interlocks
from lockprobe.statistics import judged_moments as module
from lockprobe.statistics.judged_moments import JudgedMoment, moment, weigh
from lockprobe.statistics.rationality import judge

REPORTS = (
    ReportedAttempt(3, True, 8),
    ReportedAttempt(1, False, 8),
    ReportedAttempt(2, True, 12),
    ReportedAttempt(2, True, 8),
    ReportedAttempt(0, False, 8),
)


def start(noise="aware"):
    return begin(interlocks("single-parent", 4), noise_model(noise))


@pytest.mark.parametrize("noise", ["naive", "aware"])
def test_what_is_known_after_reports_is_what_the_belief_says(noise):
    belief, now, restarts = start(noise), moment(start(noise)), 0
    for report in REPORTS:
        belief = update(belief, report)
        now, again = now.after(report)
        restarts += again
        assert now.entropy == pytest.approx(entropy(belief))
        assert now.worth.bits == pytest.approx(information(belief))
        assert now.worth.regret == pytest.approx(expected_steps(belief) - expected_steps(belief).min())
    assert restarts == belief.restarts
    end, _ = now.after(None)
    assert end.entropy == pytest.approx(entropy(opened(belief)))


def test_the_same_reports_lead_to_the_same_moment():
    one, two = moment(start()), moment(start())
    assert one is two
    assert one.after(REPORTS[0])[0] is two.after(ReportedAttempt(3, True, 8))[0]
    assert one.after(REPORTS[0])[0] is not one.after(REPORTS[1])[0]


def test_not_too_much_is_remembered(monkeypatch):
    before = moment(start())
    monkeypatch.setattr(module, "MANY", 1)
    assert moment(start()) is not before


def test_what_other_trials_left_behind_changes_no_digit():
    """A report is the same whichever process has worked at whichever agent before."""
    trials = play_study(small_study(["random", "cognitive:perseverant"], (0.0, 0.6), 1, 4))

    def judged():
        return [judge(trial, prior="single-parent", noise=noise) for trial in trials for noise in ("naive", "aware")]

    module._moments.clear()
    fresh = {(one.key, one.noise): one for one in judged()}
    module._moments.clear()
    trials.reverse()
    assert {(one.key, one.noise): one for one in judged()} == fresh


@pytest.mark.parametrize("noise", ["naive", "aware", "0.3"])
def test_attempts_are_worth_the_same_to_the_last_digit_together_and_one_by_one(noise, monkeypatch):
    monkeypatch.setattr(module, "_TOGETHER", 3)
    belief, beliefs = start(noise), [start(noise)]
    for report in REPORTS:
        belief = update(belief, report)
        beliefs.append(belief)
    together = [JudgedMoment(one) for one in (*beliefs, begin(interlocks("chains", 4), noise_model(noise)))]
    weigh(together)
    for one in together:
        assert one.worth == JudgedMoment(one.belief).worth
        assert one.worth.bits == tuple(information(one.belief))
        assert one.worth.regret == tuple(expected_steps(one.belief) - expected_steps(one.belief).min())
    before = together[0].worth
    weigh(together)
    assert together[0].worth is before
