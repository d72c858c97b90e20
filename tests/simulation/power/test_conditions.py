"""The power of the test that the report makes of every condition."""

import numpy as np
import pytest
from builders import play_study
from reported import found_in

from lockprobe.foundation.seeds import generator
from lockprobe.simulation.power import conditions
from lockprobe.simulation.power.conditions import STATED, Contrasts, condition_power, families_of, played_blocks
from lockprobe.simulation.power.simulator import Simulation
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.single import run_trial

ACTING = {"p": [0, 0.3, 0.6], "condition": ["nudge", "drop?p=0.5"], "sweep": "tremble?p=0,0.4,0.8"}


def planned(seed=1, trials=40, agent="cognitive:perseverant", **more):
    return study("flips", **({"agent": agent, "trials": trials, "repetitions": 1, "seed": seed} | ACTING | more))


def test_families_are_those_of_the_report():
    rates, tremble, others = families_of(planned())
    assert (rates.name, rates.doses) == ("flip rate", {"truth": 0, "flip?p=0.3": 0.3, "flip?p=0.6": 0.6})
    assert (tremble.name, tremble.doses) == ("tremble p", {"truth": 0, "tremble?p=0.4": 0.4, "tremble?p=0.8": 0.8})
    assert (others.name, list(others.doses)) == ("", ["truth", "nudge", "drop?p=0.5"])
    two = families_of(planned(sweep=None, modality=["symbolic", "symbolic?tell=state"]))
    assert [next(iter(one.doses)) for one in two] == ["symbolic", "symbolic", "symbolic", "truth", "truth"]
    assert list(two[2].doses) == ["symbolic", "truth"]  # the control of the other modality is compared too
    assert families_of(study("flips", agent="random", p=[0])) == ()


def test_blocks_are_the_trials_of_a_study_whatever_plays_them(monkeypatch):
    """The kernel plays flips of every reading; the loop plays what else acts, in pieces."""
    monkeypatch.setattr(conditions, "BATCH", 3)
    flips = ["flip?p=0.5&others=kept", "flip?p=0.4&inverts=position&others=noisy", "flip?p=0.3&only=moved"]
    for more in ({}, {"modality": ["symbolic", "symbolic?tell=state"], "shuffle": "study"}, {"layout": "shuffled"}):
        asked = planned(agent=["random", "cognitive:insistent"], p=[0, 0.6], condition=[*flips, "drop?p=0.5"],
                        sweep=None, seed=4, **more)  # fmt: skip
        done = []
        found = played_blocks(asked, 7, progress=lambda part, of, done=done: done.append((part, of)))
        for agent, blocks in zip(asked.agents, found, strict=True):
            settings = {"agent": agent, "seed": 4, "layout": asked.layout, "shuffle": asked.shuffle}
            trials = [
                [run_trial(condition=one, trial=i, modality=one.modality, **settings) for one in asked.conditions]
                for i in range(1, 8)
            ]
            assert blocks.tolist() == [[one.solved for one in block] for block in trials]
        assert done[-1] == (14 * len(asked.conditions),) * 2


@pytest.mark.slow
def test_it_detects_in_the_trials_of_a_study_what_the_report_detects(tmp_path):
    """Permutations are drawn by either, so that what lies about the level may be decided in two ways."""
    asked = planned(agent=["cognitive:perseverant", "cognitive:insistent"], p=[0, 0.6], trials=30)
    report, labels = found_in(tmp_path, asked), [one.label for one in asked.conditions]
    decisions = []
    for agent, solved in zip(asked.agents, played_blocks(asked, 30), strict=True):
        for family in families_of(asked):
            own = solved[:, [labels.index(label) for label in family.doses]]
            contrasts = Contrasts(agent=agent, family=family, success=(), agents=2)
            shown = contrasts.differing(own, generator(1, family.name))
            rows = report.where("success_difference", agent=agent, axis=family.name, of="", versus="")
            assert {(row.control, row.condition) for row in rows} == {("truth", label) for label in contrasts.asked}
            decisions += [(row.condition in shown, row.detected) for row in rows if not 0.03 < row.p_value < 0.08]
    assert len(decisions) >= 8
    assert set(decisions) == {(True, True), (False, False)}


def test_power_is_the_share_of_studies_in_which_it_is_detected_and_grows():
    small = condition_power(
        planned(), Simulation(trials=(10, 60), studies=20), success=[0.3, *[0.7] * 2, 0.3, *[0.7] * 3]
    )
    assert [(one.agent, one.choices, [*needed]) for one, needed in small] == [
        (STATED, 2, list(family.doses)[1:]) for family in families_of(planned())
    ]
    found = {condition: needed for _, of in small for condition, needed in of.items()}
    assert found.pop("nudge").trials is None
    for needed in found.values():
        first, last = needed.measured
        assert first.power < 0.8 < last.power
        assert 10 < needed.trials < 60


def test_shared_luck_needs_fewer_trials():
    alone = {"p": [0], "condition": "nudge", "sweep": None}
    apart, alike = (
        condition_power(planned(**alone), Simulation(trials=(50,), studies=30), success=(0.4, 0.6), shared=share)[0][1][
            "nudge"
        ]
        for share in (0.0, 1.0)
    )
    assert apart.measured[0].power + 0.3 < alike.measured[0].power


def test_without_an_effect_it_keeps_its_level():
    rows = condition_power(planned(), Simulation(trials=(30,), studies=60), success=[0.5] * 7)
    detected = [needed.measured[0].detected for _, of in rows for needed in of.values()]
    assert sum(detected) <= 10  # of 360, in three families of 60 studies at 5 %


def test_agents_are_corrected_together_and_those_that_play_alike_do_not_count(monkeypatch):
    monkeypatch.setattr("lockprobe.simulation.power.conditions.POOL", 40)
    alone = {"p": [0, 0.6], "condition": None, "sweep": None}
    agents = ["cognitive:perseverant", "cognitive:insistent", "random"]
    once, asked = Simulation(trials=(5,), studies=1), planned(agent=agents, **alone)
    found = [one for one, _ in condition_power(asked, once)]
    assert [(one.agent, one.choices) for one in found] == [(agents[0], 2), (agents[1], 2), (agents[2], 1)]
    pooled = np.mean([trial.solved for trial in play_study(planned(agent=agents[0], **alone)) if trial.p == 0.6])
    assert found[0].success[1] == pytest.approx(pooled)
    assert len(set(found[2].success)) == 1
    ((named, _),) = condition_power(asked, once, success=(0.2, 0.5))
    assert (named.agent, named.choices) == (STATED, 2)
