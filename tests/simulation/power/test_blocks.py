"""Blocks are the trials of a study, whatever number it asks for."""

from lockprobe.simulation.power import blocks
from lockprobe.simulation.power.blocks import Played, played_blocks
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.single import run_trial


def test_blocks_of_several_agents_are_their_trials_in_order(monkeypatch):
    monkeypatch.setattr(blocks, "BATCH", 3)
    planned = study(
        "flips", agent=["random", "round-robin"], p=[0], condition="drop?p=0.5", trials=1, repetitions=1, seed=4
    )
    done = []
    asked = [Played(study=planned, agent=agent, conditions=planned.conditions) for agent in planned.agents]
    found = played_blocks(asked, 7, progress=lambda part, of: done.append((part, of)))
    for agent, played in zip(planned.agents, found, strict=True):
        trials = [
            [run_trial(agent=agent, condition=one, trial=i, seed=4) for one in planned.conditions] for i in range(1, 8)
        ]
        assert played.tolist() == [[one.solved for one in block] for block in trials]
    assert done == [(part, 14) for part in (3, 6, 7, 10, 13, 14)]
