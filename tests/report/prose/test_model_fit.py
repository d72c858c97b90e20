"""Sentences say what the numbers bear."""

from dataclasses import replace

import pytest

from lockprobe.report.prose.model_fit import finding
from lockprobe.simulation.fit import AgentFit, Parameter, Predicted, RivalFit


def aside(gain, low, high):
    return Predicted(log_likelihood=-1.2, gain=gain, low=low, high=high, probability=0.3, hits=0.46)


def parameter(name, value, low, high, *, at_bound=False):
    return Parameter(name=name, value=value, low=low, high=high, at_bound=at_bound)


RANDOM = RivalFit(
    model="random",
    version="random",
    versions=1,
    spec="random",
    parameters=(),
    log_likelihood=-100.0,
    charged=0.0,
    aicc=200.0,
    bic=200.0,
    behind=30.0,
    held_out=aside(0.0, 0.0, 0.0),
)
MEMORY = replace(
    RANDOM,
    model="failure-memory",
    version="failure-memory",
    parameters=(
        parameter("failure", 2.0, 1.0, 3.0),
        parameter("decay", 0.8, 0.6, 0.9),
        parameter("reset", 0.5, 0.2, 1.0),
    ),
    behind=0.0,
    held_out=aside(0.31, 0.25, 0.37),
)


def fit_of(*rivals, own=None, lead=None):
    return AgentFit(
        agent="llm:local",
        conditions=("truth",),
        trials=30,
        left_out=0,
        passed_over=0,
        choices=400,
        clusters=30,
        repeats=1.0,
        chance_bits=2.0,
        rivals=rivals,
        described=rivals[0].model,
        lead_by_reports=lead,
        own=own,
    )


def said(*rivals, own=None, lead=None):
    return finding(fit_of(*rivals, own=own, lead=lead))


def test_what_predicts_comes_first_with_its_gain():
    assert said(MEMORY, RANDOM).startswith(
        "llm:local is best described by failure-memory: it avoids or repeats joints that failed, with a fading memory. On "
        "held-out trials, this model gains 0.31 of the 2.00 bits per choice of a random model (95 % interval 0.25 to 0.37); "
        "the chosen joint has the highest probability in 46 % of choices (random: 25 %)."
    )


def test_the_failure_memory_is_told_in_odds_and_shares():
    assert (
        "A joint that has just failed is 0.14 times (0.05 to 0.37) as likely as otherwise; of this effect 80 % (60 to "
        "90 %) remains after each further step, and a perceived move removes 50 % (20 to 100 %)."
    ) in said(MEMORY, RANDOM)
    back = replace(MEMORY, parameters=(parameter("failure", -1.0, -2.0, -0.5), *MEMORY.parameters[1:]))
    assert "A joint that has just failed is 2.7 times (1.6 to 7.4) as likely" in said(back, RANDOM)
    endless = replace(MEMORY, parameters=(parameter("failure", 15.0, 9.0, None, at_bound=True), *MEMORY.parameters[1:]))
    assert "A joint that has just failed is at most 0.001 times as likely" in said(endless, RANDOM)
    unclear = replace(MEMORY, parameters=(parameter("failure", 1.0, -0.2, 2.0), *MEMORY.parameters[1:]))
    assert said(unclear, RANDOM).endswith("No effect of failures on its choices was detected.")


def test_only_pulls_that_are_shown_are_told():
    pulls = (parameter("recent", 0.7, 0.2, 1.1), parameter("stay", 0.7, -0.2, 1.1))
    text = said(replace(MEMORY, model="win-stay-lose-shift", version="win-stay-lose-shift", parameters=pulls), RANDOM)
    assert "The joint attempted last is 2 times (1.2 to 3) as likely as otherwise." in text
    assert "if it moved" not in text
    assert "failures" not in text
    lapse = replace(
        MEMORY,
        model="human-inspired",
        version="human-inspired:target-any",
        parameters=(parameter("lapse", 0.1, 0.05, 0.2),),
    )
    assert "It lapses in 10 % (5 to 20 %) of its choices." in said(lapse, RANDOM)


WINNER = replace(
    MEMORY,
    model="favourite-labels",
    version="favourite-labels",
    parameters=(parameter("label B beside A", -1.0, -1.2, -0.8),),
)


@pytest.mark.parametrize("behind", [3.0, 140.0])
def test_nothing_is_told_of_the_parameters_of_a_model_that_lost(behind):
    """Not of its memory of failures either, however sure it is of it."""
    text = said(WINNER, replace(MEMORY, behind=behind), RANDOM)
    assert text.startswith(
        "llm:local is best described by favourite-labels: it prefers some labels. On held-out trials"
    )
    assert "times" not in text
    assert "failed" not in text
    assert fit_of(WINNER, replace(MEMORY, behind=behind), RANDOM).claims == ()


def test_nothing_is_told_of_parameters_where_the_best_is_not_shown_to_predict():
    best = replace(WINNER, held_out=aside(0.04, -0.01, 0.09))
    for rivals in ((best, replace(MEMORY, behind=8.0), RANDOM), (replace(MEMORY, held_out=None), RANDOM)):
        assert "times" not in said(*rivals)
        assert fit_of(*rivals, lead=100.0).claims == ()


def test_reports_are_said_to_act_only_where_the_model_needs_them():
    heeded, ignored = said(MEMORY, RANDOM, lead=135.4), said(MEMORY, RANDOM, lead=5.9)
    assert "It uses its reports: if every attempt counts as failed instead, BIC is 135 higher." in heeded
    assert "A joint that has just failed is 0.14 times" in heeded
    assert ignored.startswith("llm:local is best described by failure-memory. On held-out trials, this ")
    assert "avoids or repeats joints" not in ignored
    assert "0.14" not in ignored
    assert ignored.endswith(
        "No effect of reports on its choices was detected: by BIC, failure-memory is no worse if every attempt counts as "
        "failed, whatever was reported. So the effects of reports are not interpreted."
    )


def test_pulls_that_depend_on_no_report_are_told_all_the_same():
    pulls = tuple(
        parameter(name, 1.0, 0.5, 1.5) for name in ("target", "closed", "failure", "recent", "stay", "position")
    )
    best = replace(MEMORY, parameters=(*pulls, *MEMORY.parameters[1:]))
    assert [(one.about, one.direction) for one in fit_of(best, RANDOM, lead=-7.0).claims] == [
        ("target", 1),
        ("recent", 1),
        ("position", 1),
    ]
    assert [(one.about, one.direction) for one in fit_of(best, RANDOM, lead=7.0).claims] == [
        ("reports", 1),
        ("target", 1),
        ("closed", 1),
        ("failure", -1),
        ("recent", 1),
        ("stay", 1),
        ("position", 1),
    ]


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        (parameter("recent", -1.0, -1.5, -0.5), "This depends on the model: near estimates 0.37 times (0.22 to 0.61)."),
        (parameter("recent", 0.1, -0.5, 0.6), "This depends on the model: near does not detect it."),
        (parameter("stay", 1.0, 0.5, 1.5), "This depends on the model: near does not include it."),
        (parameter("recent", 1.2, 0.4, 2.0), ""),
    ],
)
def test_a_model_that_is_not_told_apart_and_says_otherwise_is_named(other, expected):
    best = replace(MEMORY, model="no-repeat", parameters=(parameter("recent", 0.7, 0.2, 1.1),))
    near = replace(MEMORY, model="near", version="near", parameters=(other,), behind=5.9)
    told = "The joint attempted last is 2 times (1.2 to 3) as likely as otherwise."
    assert said(best, near, RANDOM).endswith(f"{told} {expected}".strip())
    assert said(best, replace(near, behind=6.1), RANDOM).endswith(told)


def test_a_close_second_is_named_and_a_far_one_is_not():
    near = replace(
        MEMORY, model="no-repeat", version="no-repeat", parameters=(parameter("recent", 1, 0.5, 2),), behind=5.9
    )
    assert "No difference from it was detected for no-repeat." in said(MEMORY, near, RANDOM)
    assert "No difference" not in said(MEMORY, replace(near, behind=6.1), RANDOM)


@pytest.mark.parametrize(
    ("rivals", "expected"),
    [
        (
            (RANDOM, replace(MEMORY, held_out=aside(-0.01, -0.03, 0.01))),
            "was detected: no model is better than random by BIC.",
        ),
        (
            (replace(MEMORY, held_out=aside(0.04, -0.01, 0.09)), RANDOM),
            "was detected: the best model, failure-memory, gains 0.04 bits per choice (95 % interval -0.01 to 0.09)",
        ),
        ((replace(MEMORY, held_out=None), RANDOM), "a single cluster of trials leaves none to hold out."),
    ],
)
def test_what_predicts_nothing_is_not_called_a_description(rivals, expected):
    text = said(*rivals)
    assert text.startswith("No gain over chance in predicting the choices of llm:local was detected")
    assert expected in text
    assert "best described" not in text


def test_one_of_many_that_predicts_where_the_best_does_not_may_be_luck():
    best = replace(MEMORY, held_out=aside(0.06, -0.02, 0.14))
    other = replace(
        MEMORY, model="favourite-labels", version="favourite-labels", behind=5.8, held_out=aside(0.06, 0.001, 0.12)
    )
    assert said(best, other, RANDOM) == (
        "Whether a model predicts the choices of llm:local better than chance is uncertain: the best model, "
        "failure-memory, gains 0.06 bits per choice (95 % interval -0.02 to 0.14) on held-out trials. favourite-labels "
        "gains 0.06 bits per choice (95 % interval 0.001 to 0.120), which may be chance among 2 models."
    )
    assert "uncertain: no model is better than random by BIC. favourite-labels gains 0.06" in said(RANDOM, other)


def test_the_agents_own_probabilities_are_the_most_that_can_be_predicted():
    assert said(MEMORY, RANDOM, own=aside(0.9, 0.8, 1.0)).endswith(
        "Its recorded probabilities gain 0.90 bits per choice, the expected maximum for any model."
    )
