"""The first answer of a report: one sentence of at most 30 words, of what the tests bear out."""

import re
from functools import cache
from types import SimpleNamespace as Some

import numpy as np
import pytest
from builders import make_trial
from scipy.stats import binom

from lockprobe.boxes.families import box
from lockprobe.report.prose.first_screen import (
    effects_answer,
    flips_answer,
    no_advantage_said,
)
from lockprobe.report.prose.trials_needed import effects_needed, flips_needed
from lockprobe.statistics import rationality
from lockprobe.statistics.contrast import Effects
from lockprobe.statistics.proportions import proportion
from lockprobe.statistics.sequential.shares import share_at_every_look
from lockprobe.statistics.summary import summarise

SOLVED, UNSOLVED = [3, 2, 1, 0], [1] * 20


@pytest.fixture(scope="module", autouse=True)
def rough():
    """No sentence here is of optimal actions: a few trials are enough."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rationality, "JUDGED", 6)
        yield


def answer(**courses):
    """The answer on agents whose trials are solved as listed: agent -> p -> how many of 40."""
    return _answer(tuple((agent, tuple(by_p.items())) for agent, by_p in courses.items()))


@cache
def _answer(courses):
    courses = {agent: dict(by_p) for agent, by_p in courses}
    trials = [
        make_trial(SOLVED if (39 - i if p else i) < solved else UNSOLVED, agent=agent, p=p, trial=i + 1)
        for agent, by_p in courses.items()
        for p, solved in by_p.items()
        for i in range(40)
    ]
    return summarise(trials, box("chain-4"))


@pytest.mark.parametrize(
    ("courses", "said"),
    [
        ({"a": {0: 5, 0.4: 30}}, "False reports raise the success of a (12 % to 75 % at a flip rate of 0.4)."),
        ({"a": {0: 30, 0.4: 5}}, "False reports lower the success of a"),
        ({"a": {0: 20, 0.4: 21}}, "Inconclusive: no effect of false reports on the success of a was detected, and changes of up to 32 points"),
        ({"a": {0.4: 20}}, "a solved 50 % of 40 trials."),
        ({"a": {0: 5, 0.4: 30}, "b": {0: 30, 0.4: 5}}, "False reports raise the success of a; they lower the success of b."),
        ({"a": {0: 5, 0.4: 30}, "b": {0: 20, 0.4: 21}}, "False reports raise the success of a (12 % to 75 % at a flip rate of 0.4); no effect on that of b was detected (within ±36 points)."),
        ({"a": {0: 20, 0.4: 21}, "b": {0: 20, 0.4: 20}}, "Inconclusive: no effect of false reports on the success of a or b was detected"),
        ({"a": {0: 5}, "b": {0: 30}}, "Of 2 agents b solved the most: 75 % of 40 trials."),
    ],
)  # fmt: skip
def test_the_answer_says_what_the_tests_say(courses, said):
    found = flips_answer(answer(**courses))
    assert found.startswith(said)
    assert len(found.split()) <= 30
    assert found.count(".") - found.count("0.") == 1


def test_an_effect_that_is_shown_to_be_small_is_not_called_inconclusive():
    """Twelve hundred copies of the same choice: the interval leaves out 10 points."""
    trials = [
        make_trial(SOLVED if i % 2 else UNSOLVED, agent="a", p=p, trial=i + 1) for p in (0, 0.4) for i in range(400)
    ]
    found = flips_answer(summarise(trials, box("chain-4")))
    assert found == "No effect of false reports on the success of a was detected."


@pytest.mark.parametrize("solved", [0, 18])
def test_eighteen_pairs_that_all_agree_leave_the_question_open(solved):
    """A change of 10 points leaves 18 of 18 pairs alike in 15 % of studies."""
    trials = [
        make_trial(SOLVED if solved else UNSOLVED, agent="a", p=p, trial=i + 1) for p in (0, 0.4) for i in range(18)
    ]
    found = flips_answer(summarise(trials, box("chain-4")))
    assert found.startswith("Inconclusive: no effect of false reports on the success of a was detected")


def test_trials_needed_shrink_the_interval_to_ten_points():
    summary = answer(a={0: 20, 0.4: 21})
    (agent,) = summary.subjects
    half = (agent.contrast.difference.high - agent.contrast.difference.low) / 2
    few, most = map(int, re.search(r"about (\d+) to (\d+) trials", flips_needed(summary)).groups())
    assert 0.9 * few <= 40 * (half / 0.1) ** 2 <= most
    assert flips_needed(answer(a={0: 5, 0.4: 30})) == ""


def effects(*changes, agents=1):
    """Effects of conditions on one agent: (name, difference, whether it is shown, half an interval, differing pairs)."""
    return Effects(
        agent="a",
        modality="symbolic",
        control="truth",
        effects=tuple(effect(*change) for change in changes),
        agents=agents,
    )


def effect(name, value, shown, half=0.2, differ=24, n=50):
    pairs = Some(only_first=0, only_second=differ, n=n)
    ends = {"low": value - half, "high": value + half, "p_value": 0.01 if shown else 0.5}
    difference = Some(value=value, **ends, first=Some(n=n), pairs=pairs)
    return Some(condition=name, detectable=shown, difference=difference)


LEFT = ", and changes of up to 30 points are not excluded."


@pytest.mark.parametrize(
    ("found", "said"),
    [
        ([], "No two conditions have a trial in common yet."),
        ([effects(("x", 0.3, True))], "x raises the success of a."),
        (
            [effects(("x", 0.3, True), ("y", 0.4, True), ("z", -0.3, True), ("w", 0.0, False))],
            "x and y raise and z lowers the success of a; no effect of 1 other was detected.",
        ),
        (
            [effects(("x", 0.1, False), ("y", 0.1, False))],
            f"Inconclusive: no effect of x or y on the success of a was detected{LEFT}",
        ),
        ([effects(("x", 0.1, False))] * 2, f"Inconclusive: no effect of any condition on success was detected{LEFT}"),
        ([effects(("x", 0.01, False, 0.05))] * 2, "No effect of any condition on success was detected."),
        ([effects(("x", 0.01, False, 0.05))], "No effect of x on the success of a was detected."),
    ],
)
def test_conditions_are_named_by_what_they_do(found, said):
    assert effects_answer(found) == said


@pytest.mark.parametrize("trials", [1, 2, 3, 4, 5, 6, 10, 18, 40])
@pytest.mark.parametrize("differ", [0.1, 0.5, 0.9])
def test_the_most_trials_needed_are_seldom_too_few(trials, differ):
    """From samples of any size: the upper end holds what is needed for the true share of pairs that differ."""
    true = differ * (1.96 / 0.1) ** 2
    rng = np.random.default_rng([trials, int(10 * differ)])
    short = 0
    for count in rng.binomial(trials, differ, size=300).tolist():
        said = effects_needed([effects(("x", 0.0, False, 1.0, count, trials))])
        ends = re.search(r"about (?:\d+ to )?(\d+) trials", said)
        short += (int(ends[1]) if ends else trials) < 0.97 * true
    assert short / 300 <= 0.1


@pytest.mark.parametrize("trials", [1, 2, 3, 4, 6, 12, 17, 40])
@pytest.mark.parametrize("chance", [0.02, 0.1, 0.3, 0.69, 0.9, 0.99])
@pytest.mark.parametrize("agents", [1, 2, 10])
def test_agents_at_chance_are_seldom_said_to_be_below_or_above_it(trials, chance, agents):
    """Whatever the number of trials: one trial in ten that fails at a chance of 90 % shows nothing."""
    by_chance = binom(trials, chance)
    below, above = 0.0, 0.0
    for count in range(trials + 1):
        shares = {name: proportion(count, trials) for name in map(str, range(agents))}
        said = no_advantage_said(shares, "when told the truth", chance)
        below += by_chance.pmf(count) * ("solved fewer" in said)
        above += by_chance.pmf(count) * (not said)
    assert 1 - (1 - below) ** agents <= 0.05
    assert 1 - (1 - above) ** agents <= 0.05


def test_at_every_look_intervals_of_shares_hold_for_all_agents_at_once():
    one = share_at_every_look([i % 2 == 0 for i in range(80)])
    chance = (one.high + one.at_level(1 - 0.05 / 10).high) / 2
    assert "solved fewer" in no_advantage_said({"a": one}, "when told the truth", chance)
    many = dict.fromkeys("abcdefghij", one)
    assert "no difference from" in no_advantage_said(many, "when told the truth", chance)


def test_the_first_sentence_is_corrected_for_many_agents():
    """One of ten agents differs by chance as one in a hundred would: of ten that is nothing."""
    courses = {name: {0: 20, 0.4: 20} for name in "bcdefghij"}
    assert flips_answer(answer(a={0: 12, 0.4: 25})).startswith("False reports raise the success of a")
    together = answer(a={0: 12, 0.4: 25}, **courses)
    assert flips_answer(together).startswith("Inconclusive: no effect of false reports on the success of a, b or 8")
    for agent in together.agents:
        gap = agent.contrast.difference
        assert agent.contrast.detectable == (gap.low > 0 or gap.high < 0)
