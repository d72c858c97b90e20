"""The power of a study: what is stated is what is simulated, and the report's own test judges it."""

import numpy as np
import pytest
from reported import found_in
from scipy.special import expit

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.differences import each_difference
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.power import Clusters, Conditions, Needed, conditions_of, power
from lockprobe.studies.records.read_records import load

ACTING = {"p": [0, 0.3, 0.6], "condition": ["nudge", "drop?p=0.5"], "sweep": "tremble?p=0,0.4,0.8"}
ANY, SHAPE = "any of them", "rises and falls"


def planned(seed=1, trials=40, agent="cognitive:perseverant", **more):
    return study("flips", **({"agent": agent, "trials": trials, "repetitions": 1, "seed": seed} | ACTING | more))


@pytest.mark.parametrize(
    ("detected", "studies", "needed", "low", "high"),
    [
        ((20, 50, 70), 100, None, None, None),
        ((85, 90, 99), 100, 15, None, 23),
        ((20, 80, 99), 100, 30, 28, 40),
        ((2000, 8000, 9900), 10_000, 30, 30, 31),
        ((20, 50, 82), 100, 58, 50, None),
    ],
)
def test_what_is_needed_lies_where_power_crosses_the_target_with_the_error_of_its_simulation(
    detected, studies, needed, low, high
):
    found = Needed.of(dict(zip((15, 30, 60), detected, strict=True)), studies)
    assert (found.needed, found.low, found.high) == (needed, low, high)
    smooth = (detected[0] + 1) / (studies + 2)
    assert found.measured[0].error == pytest.approx((smooth * (1 - smooth) / studies) ** 0.5)


def test_families_are_those_of_the_report():
    rates, tremble, others = conditions_of(planned(), [0.5] * 7)
    assert (rates.family, rates.doses) == ("flip rate", {"truth": 0, "flip?p=0.3": 0.3, "flip?p=0.6": 0.6})
    assert (tremble.family, tremble.doses) == ("tremble p", {"truth": 0, "tremble?p=0.4": 0.4, "tremble?p=0.8": 0.8})
    assert (others.family, [*others.doses]) == ("", ["truth", "nudge", "drop?p=0.5"])
    two = planned(sweep=None, modality=["symbolic", "symbolic?tell=state"])
    asked = conditions_of(two, [0.5] * len(two.conditions))
    assert [next(iter(one.doses)) for one in asked] == ["symbolic", "symbolic", "symbolic", "truth", "truth"]
    assert [*asked[2].doses] == ["symbolic", "truth"]  # the control of the other modality is compared too


@pytest.mark.slow
def test_it_detects_in_the_trials_of_a_study_what_the_report_detects(tmp_path):
    """Permutations are drawn by either, so that what lies about the level may be decided in two ways."""
    asked = planned(agent=["cognitive:perseverant", "cognitive:insistent"], p=[0, 0.6], trials=30)
    report, labels = found_in(tmp_path, asked), [one.label for one in asked.conditions]
    decisions, trials = [], load(tmp_path / "study")
    for agent in asked.agents:
        solved = {label: [t.solved for t in trials if (t.agent, t.condition) == (agent, label)] for label in labels}
        for one in conditions_of(asked, [0.5] * len(labels)):
            own = Conditions(family=one.family, doses=one.doses, success=(), agents=2)
            shown = own.judged(np.array([solved[label] for label in one.doses]).T, generator(1, one.family))
            rows = report.where("success_difference", agent=agent, axis=one.family, of="", versus="")
            assert {(row.control, row.condition) for row in rows} == {("truth", label) for label in [*one.doses][1:]}
            decisions += [(row.condition in shown, row.detected) for row in rows if not 0.03 < row.p_value < 0.08]
    assert len(decisions) >= 8
    assert set(decisions) == {(True, True), (False, False)}


def test_agents_are_corrected_together_and_baselines_do_not_count():
    asked = planned(
        agent=["cognitive:perseverant", "cognitive:insistent", "random"], p=[0, 0.6], condition=None, sweep=None
    )
    (named,) = conditions_of(asked, (0.2, 0.5))
    assert named.row("flip?p=0.6").items() >= {"choices": 2, "control success": 0.2, "success": 0.5}.items()


def test_every_design_has_its_sizes_what_it_asks_and_how_many_it_corrects_for():
    agents = ["cognitive:perseverant", "cognitive:insistent"]
    (why,) = conditions_of(study("why", agent=agents), [0.5] * 7)
    (rates,) = conditions_of(study("flips", agent=agents, p=[0, 0.2, 0.4]), [0.5] * 3)
    assert (why.sizes, rates.sizes) == ((50, 150, 300, 600), (15, 30, 60, 120, 240))
    assert (why.asked, rates.asked) == ([], ["flip?p=0.2", "flip?p=0.4", ANY, SHAPE])
    assert (why.row("x")["choices"], rates.row("x")["choices"]) == (12, 4)
    (two,) = conditions_of(study("flips", agent="random", p=[0, 0.2]), [0.5] * 2)
    assert two.asked == ["flip?p=0.2"]
    people, boxes = Clusters(success=(0.2, 0.5, 0.6)), Clusters(success=(0.2, 0.5), counted="boxes")
    assert (people.sizes, people.asked, people.least) == ((30, 60, 120, 240, 480), ["2", "3"], 10)
    assert (boxes.sizes, boxes.least) == ((20, 40, 80, 160, 320), 5)
    assert Clusters(success=(0.2, 0.5), between=True).least == 20


WHY = {
    "truth": (0.23,) * 7,
    "what they say last": (0.23, 0.67, 0.23, 0.23, 0.67, 0.67, 0.23),
    "as any odd report": (0.23, *(0.67,) * 6),
}


def powers(effect, *sizes, studies=20):
    (found,) = power([effect], sizes, studies=studies)
    return {what: [rate.power for rate in of.measured] for what, of in found.items()}


def test_what_is_true_is_detected_the_more_the_larger_the_study_and_else_the_level_is_kept():
    paper, flat = (conditions_of(study("flips", agent="random", p=[0, 0.2, 0.4, 0.6]), success)[0]
                   for success in ((0.23, 0.53, 0.67, 0.5), (0.5,) * 4))  # fmt: skip
    found = powers(paper, 15, 60, studies=8)
    assert [*found] == ["flip?p=0.2", "flip?p=0.4", "flip?p=0.6", ANY, SHAPE]
    assert found["flip?p=0.4"][0] < 0.8 < found["flip?p=0.4"][1]
    assert max(max(of) for of in powers(flat, 30, studies=10).values()) <= 0.2
    beside = conditions_of(planned(p=[0], sweep=None), (0.3, 0.7, 0.3))[0]
    found = powers(beside, 60, studies=8)
    assert found["nudge"][0] > 0.8
    assert found["drop?p=0.5"][0] < 0.2


def test_a_study_of_controls_has_the_powers_of_its_verdicts():
    effects = {name: conditions_of(study("why", agent="random"), success)[0] for name, success in WHY.items()}
    assert powers(effects["truth"], 150, studies=6).keys() <= {"verdict: no change"}
    assert powers(effects["what they say last"], 150, studies=6)["claim: last"][0] > 0.8
    assert powers(effects["as any odd report"], 150, studies=6)["verdict: form"][0] > 0.8


MODELS = [{"success": (0.5, 0.7, 0.9), "each": 4, "sd": 1.5, "effect_sd": 1.0}, {"success": (0.02, 0.98), "sd": 3.0}]


@pytest.mark.parametrize("of", ["within", "between", "boxes"])
@pytest.mark.parametrize("given", MODELS)
def test_persons_and_boxes_are_solved_as_stated_and_no_person_meets_luck_twice(given, of):
    """The spread of what a person opens is that of their skill and of the luck of their boxes."""
    model = Clusters(**given, counted="boxes" if of == "boxes" else "persons", between=of == "between")
    conditions = len(model.success)
    groups = model.groups(600 * conditions, np.random.default_rng(1))
    if of == "boxes":
        assert all((one.box == groups[0].box).all() and (one.trial == groups[0].trial).all() for one in groups)
    else:
        everybody = np.concatenate([one.player for one in groups])
        assert np.unique(everybody, return_counts=True)[1].tolist() == [model.each * conditions] * 600 * conditions
        pairs = np.stack([everybody, np.concatenate([one.trial for one in groups]).astype(str)])
        assert len(np.unique(pairs, axis=1).T) == len(everybody)
        assert all(len(np.unique(one.trial)) == len(one) for one in groups)  # nobody else has it under this condition
    for place, (one, share) in enumerate(zip(groups, model.success, strict=True)):
        name = one.box if of == "boxes" else one.player
        own = np.bincount(np.unique(name, return_inverse=True)[1], one.solved) / (len(one) / len({*name}))
        assert own.mean() == pytest.approx(share, abs=0.03)
        skill = np.random.default_rng(2).normal(0, np.hypot(model.sd, model.effect_sd * bool(place)), 20_000)
        logit = np.linspace(-20, 20, 201)
        means = np.array([expit(a + skill[:2000]).mean() for a in logit])
        chance = expit(np.interp(share, means, logit) + skill)
        each = model.each * (conditions if of == "between" else 1)
        assert own.var() == pytest.approx(chance.var() + (chance * (1 - chance)).mean() / each, abs=0.015)


@pytest.mark.parametrize(
    "given", [{}, {"between": True}, {"counted": "boxes", "each": 5, "sd": 0.6, "effect_sd": 0.3}], ids=str
)
def test_of_clusters_that_is_detected_which_the_report_says(given):
    model, size = Clusters(success=(0.4, 0.6), **given), 200 if "each" not in given else 30
    luck, tests = (lambda: np.random.default_rng(3)), (lambda: np.random.default_rng(4))
    said = [str(place + 1) for place, one in each_difference(model.groups(size, luck())) if one.p_value < 0.05]
    assert model.detected(size, luck(), tests()) == said
    few, many = powers(model, size // 5, size)["2"]
    assert few < 0.6
    assert many > 0.8
    assert powers(Clusters(success=(0.5, 0.5), **given), size // 5)["2"][0] <= 0.12
