"""What an agent knew at every choice, held to the policies that are played."""

from dataclasses import replace

import numpy as np
import pytest
from builders import SOLUTION, make_trial

from lockprobe import run_trial
from lockprobe.agents.cognitive import RandomMap, SoftmaxMemory
from lockprobe.agents.human_inspired import PRESETS, HumanInspired
from lockprobe.agents.strategies import RoundRobin
from lockprobe.boxes.families import box
from lockprobe.interventions.catalogue import shipped
from lockprobe.simulation.fit.candidate_models import RIVALS, mapped
from lockprobe.simulation.fit.choices import choices_of, cluster_of, hear, rule
from lockprobe.simulation.fit.likelihood import Lapse
from lockprobe.simulation.fit.unpredicted import why_unpredicted

KINDS = [("chain-4", "transient"), ("chain-4", "sticky"), ("chain-4", "outcome-only"), ("random-6-17", "transient")]
PARAMETERS = {
    "target": 0.7, "closed": -0.4, "failure": 1.6, "recent": 0.3, "stay": -0.9, "position": 0.8, "decay": 0.6, "reset": 0.3,
}  # fmt: skip


class Open(HumanInspired):
    """The human-inspired strategy, with its probabilities in the record."""

    exact = True


CONDITIONS = (
    "burst?p=0.4", "correction?p=0.4", "delay?lag=1", "delay?lag=3 + flip?p=0.3", "distract?p=0.4", "drop?p=0.4", "drop?p=0.4 + symbolic",
    "flip?p=0.4 + tremble?p=0.3", "force?at=3", "nudge", "remark", "reword?p=0.4", "tremble?p=0.4 + symbolic", "tremble?p=0.4 + drop?p=0.3", "warn", "yoked?p=0.4",
)  # fmt: skip
"""Every intervention at the places told, asked and done that a strategy can be played under."""


def played(agent, name="chain-4", flip="transient", n=12):
    return [run_trial(agent=agent, box=name, flip=flip, p=0.3, trial=i, seed=3) for i in range(1, n + 1)]


def played_under(condition, agent, n=8):
    return [run_trial(agent=agent, condition=condition, trial=i, seed=3) for i in range(1, n + 1)]


def known(trials, boxes=None):
    heard = [hear(trial, boxes) for trial in trials]
    return choices_of(trials, heard), heard


def recorded(trials):
    return np.array([step.decision.probabilities for trial in trials for step in trial.steps])


@pytest.mark.parametrize(("name", "flip"), KINDS)
def test_the_softmax_gives_every_choice_the_probability_that_it_was_drawn_with(name, flip):
    trials = played(SoftmaxMemory(**PARAMETERS), name, flip)
    choices, heard = known(trials)
    model = RIVALS["softmax-memory"].versions(choices, heard)["softmax-memory"]
    values = np.array([PARAMETERS[parameter] for parameter in model.bounds])
    assert model.probabilities(values) == pytest.approx(recorded(trials), abs=1e-12)
    assert choices.own == pytest.approx(recorded(trials))


@pytest.mark.parametrize(("name", "flip"), KINDS)
@pytest.mark.parametrize("avoid", ["none", "last", "failed"])
@pytest.mark.parametrize("window", [0, 1, 3])
def test_so_does_every_random_map(name, flip, avoid, window):
    if avoid == "last" and not window:
        return
    trials = played(RandomMap(window=window, avoid=avoid, lapse=0.3), name, flip, n=5)
    choices, _ = known(trials)
    model = Lapse.of(follows=mapped(choices, window, avoid), chosen=choices.chosen, present=choices.present)
    assert model.probabilities(np.array([0.3])) == pytest.approx(recorded(trials), abs=1e-12)


@pytest.mark.parametrize(("name", "flip"), KINDS)
@pytest.mark.parametrize("preset", PRESETS)
def test_so_does_every_human_inspired_strategy(name, flip, preset):
    trials = played(Open(**PRESETS[preset], lapse=0.2), name, flip, n=4)
    choices, heard = known(trials, {name: box(name)})
    model = RIVALS["human-inspired"].versions(choices, heard)[f"human-inspired:{preset}"]
    assert model.probabilities(np.array([0.2])) == pytest.approx(recorded(trials), abs=1e-12)


@pytest.mark.parametrize("condition", CONDITIONS)
def test_under_every_condition_a_choice_has_the_probability_that_it_was_drawn_with(condition):
    """An attempt other than the chosen one, a report of an earlier attempt, no report: models know what policies do."""
    trials = played_under(condition, SoftmaxMemory(**PARAMETERS))
    choices, heard = known(trials)
    model = RIVALS["softmax-memory"].versions(choices, heard)["softmax-memory"]
    values = np.array([PARAMETERS[parameter] for parameter in model.bounds])
    assert model.probabilities(values) == pytest.approx(recorded(trials), abs=1e-12)
    for window, avoid in ((0, "failed"), (1, "last"), (3, "none")):
        trials = played_under(condition, RandomMap(window=window, avoid=avoid, lapse=0.3), n=4)
        choices, _ = known(trials)
        lapsing = Lapse.of(follows=mapped(choices, window, avoid), chosen=choices.chosen, present=choices.present)
        assert lapsing.probabilities(np.array([0.3])) == pytest.approx(recorded(trials), abs=1e-12)
    trials = played_under(condition, Open(lapse=0.2), n=4)
    choices, heard = known(trials)
    preset = RIVALS["human-inspired"].versions(choices, heard)["human-inspired:target-first"]
    assert preset.probabilities(np.array([0.2])) == pytest.approx(recorded(trials), abs=1e-12)


def test_these_are_all_conditions_that_models_predict_and_strategies_can_read():
    acting = {spec.split("?")[0] for condition in CONDITIONS for spec in condition.split(" + ")} - {"symbolic"}
    assert acting | {"confidence", "hypothesis", "phantom", "prompt"} == {
        name for name in shipped() if "?" not in name and not why_unpredicted([name])
    }


def test_a_rule_that_ignores_reports_is_followed_to_the_letter():
    trials = played("round-robin", n=3)
    choices, heard = known(trials)
    assert (rule(RoundRobin(), heard).argmax(axis=1) == choices.chosen).all()


def test_the_panel_is_looked_at_only_where_it_is_the_panel_of_these_trials():
    trial = make_trial([0, 1, 2])
    assert hear(trial, {"chain-4": box("chain-4")}).view.places
    assert not hear(trial).view.places
    assert not hear(trial, {"chain-4": box("random-4-1")}).view.places
    choices, heard = known([trial])
    assert "human-inspired:proximity" not in RIVALS["human-inspired"].versions(choices, heard)


def test_boxes_of_different_size_lie_side_by_side():
    agent = SoftmaxMemory(**PARAMETERS)
    small, large = played(agent, n=3), played(agent, "random-6-17", n=3)
    choices, heard = known([*small, *large])
    model = RIVALS["softmax-memory"].versions(choices, heard)["softmax-memory"]
    values = np.array([PARAMETERS[parameter] for parameter in model.bounds])
    found, n = model.probabilities(values), len(recorded(small))
    assert found[:n, :4] == pytest.approx(recorded(small))
    assert (found[:n, 4:] == 0).all()
    assert found[n:] == pytest.approx(recorded(large))
    assert sorted(set(choices.joints.tolist())) == [4, 6]


def test_what_was_known_stands_at_the_choice_before_the_report():
    """Joints 3, 1, 1 of chain-4: the first moves, the second does not, and does not again."""
    choices, _ = known([make_trial([3, 1, 1, 2])])
    assert choices.recent.tolist() == [[-1, -1, -1], [7, -1, -1], [2, 7, -1], [2, 2, 7]]
    assert choices.done.tolist() == choices.chosen.tolist() == [3, 1, 1, 2]
    assert choices.closed[:, 3].tolist() == [True, False, False, False]
    assert choices.age.tolist() == [[-1] * 4, [-1] * 4, [-1, 0, -1, -1], [-1, 0, -1, -1]]
    assert choices.failed.tolist() == [0, 0, 2, 2]
    assert choices.stayed.sum(axis=1).tolist() == [0, 1, 0, 0]
    assert not len(choices.own)


def test_some_choices_are_those_rows_and_no_others():
    choices, _ = known(played(SoftmaxMemory(), n=2))
    odd = np.arange(len(choices)) % 2 == 1
    some = choices.at(odd)
    assert len(some) == odd.sum()
    assert (some.chosen == choices.chosen[odd]).all()
    assert (some.own == choices.own[odd]).all()


def test_luck_is_shared_by_equal_trials_of_equal_repetitions():
    trials = [make_trial([0], repetition=r, trial=t, p=p) for p in (0.0, 0.5) for r in (1, 2) for t in (1, 2)]
    assert known(trials)[0].cluster.tolist() == [0, 1, 2, 3, 0, 1, 2, 3]


def test_labels_are_told_apart_from_places():
    trial = replace(make_trial([3, 0]), listing=("D", "C", "B", "A"))
    choices, _ = known([trial])
    assert choices.chosen.tolist() == [0, 3]
    assert choices.label.tolist() == [[3, 2, 1, 0]] * 2
    assert choices.target[0].tolist() == [False, False, False, True]


def test_a_cluster_is_one_luck_and_of_people_one_person():
    agent, lied_to = (make_trial(SOLUTION, p=p, repetition=2, trial=3) for p in (0, 0.4))
    person = make_trial(SOLUTION, agent="participant:aaaa")
    assert cluster_of(agent) == cluster_of(lied_to) != cluster_of(replace(agent, trial=4))
    assert cluster_of(person) == cluster_of(replace(person, trial=4, repetition=3))
    assert cluster_of(person) != cluster_of(replace(person, agent="participant:bbbb"))
