"""The answer of a report: one sentence of at most 30 words, of what the tests bear out."""

import re
from dataclasses import replace
from functools import cache
from types import SimpleNamespace as Some

import numpy as np
import pytest
from builders import make_trial, play_study, small_study
from scipy.stats import binom

from lockprobe.boxes.families import box
from lockprobe.interventions.flip import flip_of
from lockprobe.report.prose.first_screen import (
    effects_answer,
    flips_answer,
    interaction_said,
    no_advantage_said,
    not_above_chance,
    trial_said,
)
from lockprobe.report.prose.trials_needed import effects_needed, flips_needed
from lockprobe.statistics import rationality
from lockprobe.statistics.conditions.effects import Effects
from lockprobe.statistics.proportions import proportion
from lockprobe.statistics.sequential.shares import share_at_every_look
from lockprobe.statistics.summary import summarise
from lockprobe.trial.record import STATES

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


def test_many_agents_are_counted_and_not_all_named():
    found = flips_answer(answer(**{name: {0: 20, 0.4: 20 + i} for i, name in enumerate("abcdef")}))
    assert found == (
        "Inconclusive: no effect of false reports on the success of a, b or 4 others was detected, "
        "and changes of up to 49 points are not excluded."
    )


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


def test_agents_that_ignore_reports_are_said_to():
    study = small_study(["random"], (0.0, 0.4), 1, 6)
    found = flips_answer(summarise(play_study(study), box("chain-4")))
    assert re.match(
        r"random played alike whatever it was told, so it acts on at most \d+ % of reports: it solved", found
    )
    assert len(found.split()) <= 30


def test_trials_needed_shrink_the_interval_to_ten_points():
    summary = answer(a={0: 20, 0.4: 21})
    (agent,) = summary.subjects
    half = (agent.contrast.difference.high - agent.contrast.difference.low) / 2
    few, most = map(int, re.search(r"about (\d+) to (\d+) trials", flips_needed(summary)).groups())
    assert 0.9 * few <= 40 * (half / 0.1) ** 2 <= most
    assert flips_needed(answer(a={0: 5, 0.4: 30})) == ""


def test_trials_needed_of_several_agents_shrink_the_widest_of_their_intervals():
    """An interval that is corrected for six agents shrinks to ten points later than that of one."""
    one = answer(f={0: 20, 0.4: 21})
    six = answer(**{name: {0: 20, 0.4: 21} for name in "abcdef"})
    said = r"about (\d+) to (\d+) trials"
    (few, most), (alone, _) = (map(int, re.search(said, flips_needed(summary)).groups()) for summary in (six, one))
    contrast = six.agents[-1].contrast
    half = (contrast.difference.high - contrast.difference.low) / 2
    assert alone < 0.9 * 40 * (half / 0.1) ** 2 <= most
    assert few > 1.5 * alone


def effects(*changes, agents=1):
    """Effects of conditions on one agent: (name, difference, whether it is shown, half an interval, differing pairs)."""
    return Effects(
        agent="a",
        modality="symbolic",
        control="truth",
        effects=tuple(effect(*change) for change in changes),
        interplays=(),
        agents=agents,
    )


def effect(name, value, shown, half=0.2, differ=24, n=50):
    pairs = Some(only_first=0, only_second=differ, n=n)
    ends = {"low": value - half, "high": value + half, "p_value": 0.01 if shown else 0.5}
    difference = Some(value=value, **ends, first=Some(n=n), pairs=pairs)
    return Some(condition=name, detectable=shown, difference=difference)


WIDE = ", and changes of up to 50 points are not excluded."
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


def test_people_are_named_as_such():
    people = replace(effects(("x", 0.3, True)), agent="participant")
    assert effects_answer([people]) == "x raises the success of people."
    both = [people, effects(("y", -0.3, True), ("z", 0.1, False))]
    assert effects_answer(both) == "x raises the success of people; y lowers the success of a."
    assert effects_answer(both, many=5) == f"Inconclusive: no effect of any condition on success was detected{WIDE}"
    many = "x raises the success of people; " * 3 + "effects on 2 more agents were detected."
    assert effects_answer([people] * 5) == many


def test_beside_conditions_that_changed_nothing_the_others_are_meant():
    assert effects_answer([effects(("x", 0.01, False, 0.05))] * 2, other=True) == (
        "No effect of any other condition on success was detected."
    )
    assert effects_answer([effects(("x", 0.01, False, 0.05))], other=True) == (
        "No effect of x on the success of a was detected."
    )


def test_trials_needed_of_conditions_are_those_of_the_widest_interval():
    """With 24 of 50 pairs that differ, 48 % are expected to, and at most 61 %."""
    assert effects_needed([effects(("x", 0.1, False))]) == (
        "Estimating the change under x to ±10 points takes about 190 to 240 trials per condition; this study has 50."
    )


def test_of_several_agents_the_one_with_the_widest_interval_is_named():
    """All pairs of the second differ, and it has two conditions to choose from."""
    other = replace(effects(("x", 0.1, False, 0.3, 50), ("y", 0.1, False, 0.3, 50)), agent="b")
    assert effects_needed([effects(("x", 0.1, False)), other]) == (
        "Estimating the change of b under x to ±10 points takes about 500 to 510 trials per condition; it has 50."
    )


def test_trials_needed_of_conditions_are_more_where_several_agents_are_judged_together():
    """With 24 of 50 pairs that differ, 48 % are expected to; of ten agents each has an interval of 99.5 %."""
    assert effects_needed([effects(("x", 0.1, False), agents=10)]) == (
        "Estimating the change under x to ±10 points takes about 380 to 490 trials per condition; this study has 50."
    )


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


def test_how_many_trials_of_people_is_not_said_where_their_interval_has_no_end():
    people = effects(("x", 0.1, False, 1.1))
    (one,) = people.effects
    unpaired = Some(**{**vars(one.difference), "pairs": None})
    assert effects_needed([replace(people, effects=(Some(**{**vars(one), "difference": unpaired}),))]) == ""


def test_agents_near_chance_are_said_to_be():
    """Random agents without immediate repeats solve 69 % of chain-4 in 20 steps."""
    assert not_above_chance(answer(a={0: 39, 0.4: 20})) == ""
    chance = "random agents without immediate repeats (69 %)"
    undetected = f"When told the truth, no difference from {chance} was detected for "
    assert not_above_chance(answer(a={0: 30, 0.4: 39}, b={0: 39})) == f"{undetected}a."
    assert not_above_chance(answer(a={0: 22}, b={0: 30}, c={0: 40})) == f"{undetected}a or b."
    fewer = f"solved fewer boxes than {chance}"
    assert not_above_chance(answer(a={0: 5})) == (
        f"When told the truth, a (12 %, exact 95 % interval 4 to 27 %) {fewer}."
    )
    b = "b (12 %, simultaneous exact 95 % interval 3 to 30 %)"
    assert not_above_chance(answer(a={0: 40}, b={0: 5}, c={0: 30})) == (
        f"When told the truth, {b} {fewer}; no difference from them was detected for c."
    )
    a, b = "a (15 %, simultaneous exact 95 % interval 4 to 33 %)", "b (12 %, 3 to 30 %)"
    assert not_above_chance(answer(a={0: 6}, b={0: 5}, c={0: 40})) == f"When told the truth, {a} and {b} {fewer}."


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


def test_rates_are_left_out_of_an_answer_that_they_make_too_long():
    found = flips_answer(answer(**{name: {0: 5, 0.4: 30} for name in "abc"}))
    assert found == "False reports raise the success of a, b and c."


def test_the_effect_that_was_not_detected_is_compared_with_that_which_was():
    """Two effects that differ, two that do not, and none where both were detected."""
    assert re.fullmatch(
        r"A difference in effect between b and a was detected, from a flip rate of 0 to 0\.4 \(change of a minus that of "
        r"b: \+60 points, 95 % interval \+31 to \+89; P < 0\.001; 40 trials that both finished\)\.",
        interaction_said(answer(a={0: 5, 0.4: 30}, b={0: 20, 0.4: 21})),
    )
    same = interaction_said(answer(a={0: 10, 0.4: 25}, b={0: 20, 0.4: 31}))
    assert re.fullmatch(
        r"No difference in effect between (a and b|b and a) was detected, from a flip rate of 0 to 0\.4 \(change of . "
        r"minus that of .: \S\d+ points, 95 % interval \S\d+ to \S\d+; P = [\d.]+; 40 trials that both finished\)\.",
        same,
    )
    assert interaction_said(answer(a={0: 5, 0.4: 30}, b={0: 30, 0.4: 5})) == ""
    assert interaction_said(answer(a={0: 20, 0.4: 21}, b={0: 20, 0.4: 20})) == ""
    three = interaction_said(answer(a={0: 5, 0.4: 30}, b={0: 20, 0.4: 21}, c={0: 20, 0.4: 20}))
    assert three == (
        "The effect on a was found to differ from that on b (at a flip rate of 0.4) and c (at a flip rate of 0.4)."
    )
    some = {"b": {0: 20, 0.4: 21}, "c": {0: 20, 0.4: 31}}
    assert interaction_said(answer(a={0: 10, 0.4: 25}, **some)) == (
        "The effect on a was found to differ from that on b (at a flip rate of 0.4); no difference from that on c was "
        "detected."
    )
    assert interaction_said(answer(a={0: 10, 0.4: 25}, d={0: 10, 0.4: 25}, c={0: 20, 0.4: 31})) == (
        "No difference in effect between a or d and c was detected."
    )


def test_a_comparison_of_effects_names_the_trials_that_both_agents_share():
    """One agent stopped early: 18 of its 40 trials are common."""
    trials = [
        make_trial(SOLVED if i % 2 == (p > 0 and agent == "a") else UNSOLVED, agent=agent, p=p, trial=i + 1)
        if agent == "b" or not p
        else make_trial(SOLVED, agent=agent, p=p, trial=i + 1)
        for agent, n in (("a", 40), ("b", 18))
        for p in (0, 0.4)
        for i in range(n)
    ]
    assert "; 18 trials that both finished)." in interaction_said(summarise(trials))


def test_the_first_sentence_says_on_which_trials_two_reports_are_compared():
    trials = [make_trial(SOLVED, agent="a", p=0, trial=i + 1) for i in range(40)]
    trials += [make_trial(UNSOLVED, agent="a", p=0.4, trial=i + 1) for i in range(18)]
    assert flips_answer(summarise(trials)).endswith(
        "a (100 % to 0 % at a flip rate of 0.4, of the 18 trials finished under both)."
    )


@pytest.mark.parametrize(
    ("solved", "said"),
    [
        ({"a": 20, "b": 20}, "The 2 agents solved the same share: 50 % of 40 trials."),
        ({"a": 20, "b": 20, "c": 20}, "The 3 agents solved the same share: 50 % of 40 trials."),
        (
            {"a": 21, "b": 21, "c": 20},
            (
                "Of 3 agents a and b solved the most: 52 % of 40 trials each; by the comparisons of pairs any of 3 may "
                "be the best."
            ),
        ),
        ({"a": 38, "b": 38, "c": 2}, "Of 3 agents a and b solved the most: 95 % of 40 trials each."),
        (
            {"a": 21, "b": 20},
            "Of 2 agents a solved the most: 52 % of 40 trials; by the comparisons of pairs any of 2 may be the best.",
        ),
    ],
)
def test_a_tie_has_no_single_best(solved, said):
    assert flips_answer(answer(**{agent: {0: count} for agent, count in solved.items()})) == said


def test_the_first_sentence_is_corrected_for_many_agents():
    """One of ten agents differs by chance as one in a hundred would: of ten that is nothing."""
    courses = {name: {0: 20, 0.4: 20} for name in "bcdefghij"}
    assert flips_answer(answer(a={0: 12, 0.4: 25})).startswith("False reports raise the success of a")
    together = answer(a={0: 12, 0.4: 25}, **courses)
    assert flips_answer(together).startswith("Inconclusive: no effect of false reports on the success of a, b or 8")
    for agent in together.agents:
        gap = agent.contrast.difference
        assert agent.contrast.detectable == (gap.low > 0 or gap.high < 0)


@pytest.mark.parametrize(
    ("flip", "modality", "inverted"),
    [
        ("memoryless", STATES, "the reported position of the attempted joint is inverted in one report."),
        ("latched", STATES, "the reported position of the attempted joint is inverted until its next attempt."),
        ("independent", STATES, "a reported position is inverted, for every joint in every report."),
        (
            "re-observed",
            STATES,
            "the reported outcome is inverted; a false position is corrected when another joint is attempted.",
        ),
        (
            "integrated",
            STATES,
            "the reported outcome is inverted; a false position stays until its joint is attempted again.",
        ),
        ("outcome-only", "symbolic?tell=outcome", "the reported outcome is inverted."),
    ],
)
def test_the_flip_rate_is_a_probability_and_no_share_of_false_reports(flip, modality, inverted):
    assert trial_said(20, "flips", flip_of(flip), [modality]).endswith(
        f"The flip rate is the probability that {inverted}"
    )


def test_the_agent_that_needs_more_trials_is_named():
    found = flips_needed(answer(a={0: 5, 0.4: 30}, b={0: 20, 0.4: 21}))
    assert re.fullmatch(
        r"Estimating the change of b to ±10 points takes about \d+ to \d+ trials per flip rate; it has 40\.", found
    )
