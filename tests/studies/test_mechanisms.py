"""The study of mechanisms that ships: it can be had by its name, and tells rises from declines."""

from dataclasses import replace

import numpy as np
import pytest
from builders import play_study

from lockprobe.interventions.conditions import flips
from lockprobe.statistics.differences import any_difference
from lockprobe.statistics.outcomes import outcomes
from lockprobe.statistics.two_lines import two_lines
from lockprobe.studies.options.study_options import SHIPPED
from lockprobe.studies.options.studyfile import study


@pytest.mark.parametrize("name", SHIPPED)
def test_what_ships_is_a_study(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = study(name)
    assert found.p == tuple(round(0.1 * i, 1) for i in range(11))
    assert found.repetitions * found.trials >= 300


def test_a_file_of_the_same_name_here_goes_before(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mechanisms.toml").write_text('study = "flips"\nagent = ["random"]\np = [0.3]\n')
    assert study("mechanisms.toml").p == (0.3,)


@pytest.mark.slow
def test_it_tells_which_agents_rise_which_fall_and_which_do_both():
    kinds = {
        "human-inspired": ({-1}, False),
        "ideal-observer": (set(), False),
        "cognitive:perseverant": ({1}, False),
        "cognitive:random-map?window=1&avoid=last": ({1}, True),
    }
    whole = study("mechanisms.toml")
    assert set(kinds) <= set(whole.agents)
    part = replace(whole, agents=tuple(kinds), conditions=flips((0.0, 0.5, 1.0)), repetitions=1, trials=90)
    trials = play_study(part)
    for agent, (ways, both) in kinds.items():
        own = outcomes([trial for trial in trials if trial.agent == agent])
        found = any_difference(own, np.random.default_rng(1), agents=4)
        assert {np.sign(one.value) for one in found if one.p_value < 0.05} == ways, agent
        lines = two_lines(own.dose, own.solved)
        assert (lines.direction == "inverted U" and 4 * lines.p_value < 0.05) is both, agent
