"""A learned policy in a study: it says how it acts, and plays on what it learned from or not at all."""

import pytest
from painted import painted_twins

from lockprobe import run_trial
from lockprobe.foundation.errors import BadValue
from lockprobe.interfaces.gymnasium.learned_agent import LearnedAgent


class Stubborn(LearnedAgent):
    """Attempts the first joint, and keeps what it was given."""

    def __init__(self):
        self.given = []

    def act(self, observations, rng):
        self.given.append(observations)
        return 0


class Looker(Stubborn):
    observation = "rgb"


@pytest.fixture
def painted(monkeypatch):
    return painted_twins(monkeypatch)


def test_it_has_to_say_how_it_acts():
    trial = run_trial(agent=LearnedAgent())
    assert (trial.ending, trial.error.boundary) == ("error", "model")
    assert "NotImplementedError" in trial.error.message


@pytest.mark.parametrize("modality", ["rgb", "rgbd"])
def test_what_learned_from_reports_refuses_pictures_in_one_line(painted, modality):
    agent = Stubborn()
    with pytest.raises(BadValue) as refused:
        run_trial(agent=agent, plant="fast-twin", modality=modality)
    assert str(refused.value).startswith("modality: got 'pictures', expected reports: Stubborn cannot read pictures")
    assert agent.given == []


def test_what_learned_from_pictures_is_shown_them(painted):
    agent = Looker()
    trial = run_trial(agent=agent, plant="fast-twin", modality="rgb", max_steps=2)
    assert trial.ending == "budget"
    assert [seen.shape[0] for seen in agent.given] == [1, 2]
    assert agent.given[0].shape[3] == 3


class Unaided(Stubborn):
    observation = "symbolic?tell=state"


def test_where_states_alone_are_told_outcomes_come_of_comparing_them():
    """As for every strategy; one that learned without outcomes gets none."""
    compared, unaided = Stubborn(), Unaided()
    trial = run_trial(agent=compared, p=0.4, seed=3)
    told = [0, *(2 if step.told_moved else 1 for step in trial.steps)]
    assert compared.given[-1][:, 2].tolist() == told[:-1]
    assert {1, 2} <= set(told)
    run_trial(agent=unaided, p=0.4, seed=3)
    assert set(unaided.given[-1][:, 2].tolist()) == {0}
    assert (unaided.given[-1][:, 3:] == compared.given[-1][:, 3:]).all()
