"""A report that is corrected at once leaves nothing false, and its words say both."""

import pytest

from lockprobe.errors import BadValue
from lockprobe.interventions.correction import Correction
from lockprobe.studies.single import run_trial


def steps(condition, seed=1, **more):
    trial = run_trial(agent="round-robin", condition=condition, seed=seed, box="chain-7", max_steps=30, **more)
    return trial.steps


def lies(seed):
    told = steps("flip?p=0.4", seed, modality="symbolic")
    return [step.step for step in told if step.told_falsely]


@pytest.mark.parametrize("of", ["lie", "truth"])
def test_it_hits_the_steps_at_which_the_flip_lies_and_nothing_stays_false(of):
    for seed in range(1, 6):
        found = steps(f"correction?p=0.4&of={of}", seed)
        assert [step.step for step in found if "Correction:" in step.told] == lies(seed) != []
        assert not any(step.told_falsely for step in found)


@pytest.mark.parametrize("modality", ["symbolic", "symbolic?tell=state", "symbolic?form=json", "symbolic?form=table"])
def test_the_first_report_is_the_one_of_the_flip_and_the_second_the_true_one(modality):
    flipped, true = steps("flip?p=1", modality=modality), steps("truth", modality=modality)
    for first, second, said in zip(flipped, true, steps("correction?p=1", modality=modality), strict=True):
        words = said.told.split("Correction:")
        assert [part.strip() for part in words] == [first.told, second.told]
    for second, said in zip(true, steps("correction?p=1&of=truth", modality=modality), strict=True):
        assert said.told.split("Correction:")[0].strip() == second.told


def test_strategies_play_as_in_truth():
    for agent in ("human-inspired", "cognitive:careful", "ideal-observer"):
        truth, corrected = (run_trial(agent=agent, condition=acting) for acting in ("", "correction?p=0.5"))
        assert truth.actions == corrected.actions


def test_what_it_corrects_is_one_of_two():
    with pytest.raises(BadValue, match="at: got 0, expected a step from 1"):
        Correction(at=(3, 0))
    with pytest.raises(BadValue, match="of: got 'half', expected one of lie, truth"):
        Correction(of="half")


@pytest.mark.parametrize("later", ["drop?p=1", "delay?lag=2"])
def test_a_report_that_is_dropped_or_late_has_no_correction(later):
    for told, plain in zip(steps(f"correction?p=1 + {later}"), steps(later), strict=True):
        assert (told.told, told.told_moved) == (plain.told, plain.told_moved)
        assert "Correction" not in told.told
