"""A report in two statements: its words have both, and what the last one says is what was told."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.correction import Correction
from lockprobe.studies.running.single import run_trial

SAYS = ("lie", "truth")


def steps(condition, seed=1, **more):
    trial = run_trial(agent="round-robin", condition=condition, seed=seed, box="chain-7", max_steps=30, **more)
    return trial.steps


@pytest.mark.parametrize("last", SAYS)
@pytest.mark.parametrize("first", SAYS)
def test_it_hits_the_steps_at_which_the_flip_lies_and_the_last_statement_is_what_is_told(first, last):
    for seed in range(1, 4):
        lies = [step.step for step in steps("flip?p=0.4", seed) if step.told_falsely]
        found = steps(f"correction?p=0.4&first={first}&last={last}", seed)
        assert [step.step for step in found if "Correction:" in step.told] == lies != []
        assert [step.step for step in found if step.told_falsely] == (lies if last == "lie" else [])


@pytest.mark.parametrize("reading", ["", "&others=kept", "&inverts=position", "&inverts=position&others=kept"])
@pytest.mark.parametrize("first", SAYS)
def test_a_lie_that_stands_last_is_the_false_report_of_the_flip(first, reading):
    flipped = steps(f"flip?p=0.4{reading}")
    for plain, said in zip(flipped, steps(f"correction?p=0.4&first={first}&last=lie{reading}"), strict=True):
        assert (said.told_moved, said.told_state) == (plain.told_moved, plain.told_state)
        assert said.told.split("Correction:")[-1].strip() == plain.told


@pytest.mark.parametrize("modality", ["symbolic", "symbolic?tell=state", "symbolic?form=json", "symbolic?form=table"])
def test_each_statement_is_the_report_that_says_it_alone(modality):
    """While nothing false was told before, the lie is the flip's and the truth the true report."""
    flipped, true = steps("flip?p=1&at=3", modality=modality)[2], steps("truth", modality=modality)[2]
    alone = {"lie": flipped.told, "truth": true.told}
    assert flipped.told != true.told
    for first in SAYS:
        for last in SAYS:
            said = steps(f"correction?p=1&at=3&first={first}&last={last}", modality=modality)
            words = [part.strip() for part in said[2].told.split("Correction:")]
            assert words == [alone[first], alone[last]]
            assert not any("Correction:" in step.told for step in (*said[:2], *said[3:]))


def test_strategies_play_by_the_last_statement():
    for agent in ("human-inspired", "cognitive:careful"):
        truth, lies = (run_trial(agent=agent, condition=acting) for acting in ("", "flip?p=0.5"))
        assert truth.actions != lies.actions
        for first in SAYS:
            last_true, last_false = (
                run_trial(agent=agent, condition=f"correction?p=0.5&first={first}&last={last}")
                for last in ("truth", "lie")
            )
            assert (last_true.actions, last_false.actions) == (truth.actions, lies.actions)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"at": (3, 0)}, "at: got 0, expected a step from 1"),
        ({"first": "half"}, "first: got 'half', expected one of lie, truth"),
        ({"last": "half"}, "last: got 'half', expected one of lie, truth"),
        ({"others": "noisy"}, "others: got 'noisy', expected one of fresh, kept"),
        ({"inverts": "all"}, "inverts: got 'all', expected one of position, outcome"),
        ({"p": 2}, "correction rate p: got 2"),
    ],
)
def test_what_it_cannot_say_is_one_line(given, said):
    with pytest.raises(BadValue, match=said):
        Correction(**given)


@pytest.mark.parametrize("later", ["drop?p=1", "delay?lag=2"])
def test_a_report_that_is_dropped_or_late_has_no_correction(later):
    for told, plain in zip(steps(f"correction?p=1 + {later}"), steps(later), strict=True):
        assert (told.told, told.told_moved) == (plain.told, plain.told_moved)
        assert "Correction" not in told.told
