"""One step is the experimenter's."""

from lockprobe.studies.single import run_trial


def test_one_step_is_drawn_and_all_others_are_the_agent_s():
    trial = run_trial(agent="round-robin", condition="force?at=3", box="chain-7", seed=2)
    assert [step.step for step in trial.steps if step.chosen is not None] == [3]
    plain = run_trial(agent="round-robin", box="chain-7", seed=2)
    assert trial.actions[:2] == plain.actions[:2]
    assert trial.steps[2].chosen == plain.actions[2]
