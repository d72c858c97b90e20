"""The physical box as an environment: its pictures are those of studies, in one process and in many."""

import subprocess
import sys
import textwrap
from itertools import pairwise

import gymnasium
import numpy as np
from gymnasium.utils.env_checker import check_env

from lockprobe import run_trial
from lockprobe.environment.agent import LearnedAgent
from lockprobe.environment.single import LockboxEnv
from lockprobe.pictures.png import from_png

SMALL = "fast-twin?width=64&height=64&looks=varied&depth_noise=0.001"


class Solver(LearnedAgent):
    observation = "rgbd"

    def act(self, observations, rng):
        return 4 - len(observations["rgb"])


def test_gymnasium_finds_nothing_to_say_against_it():
    check_env(gymnasium.make("lockprobe/Lockbox-v0", observation="rgbd", plant=SMALL).unwrapped, skip_render_check=True)


def test_an_episode_shows_the_pictures_of_the_study(tmp_path):
    trial = run_trial(agent=Solver(), plant=SMALL, modality="rgbd", seed=5, trial=3, shuffle=False, pictures=tmp_path)
    assert trial.solved
    env = LockboxEnv(observation="rgbd", plant=SMALL, render_mode="rgb_array")
    here = [env.reset(seed=5, options={"trial": 3})[0], *(env.step(joint)[0] for joint in (3, 2, 1, 0))]
    assert (env.render() == here[-1]["rgb"]).all()
    for seen, names in zip(here, (trial.opening_pictures, *(step.pictures for step in trial.steps)), strict=True):
        assert (seen["rgb"] == from_png((tmp_path / names["rgb"]).read_bytes())).all()
        millimetres = np.rint(seen["depth"][..., 0] * 1000).astype(int)
        assert (millimetres == from_png((tmp_path / names["depth16"]).read_bytes())).all()
    assert np.median(here[0]["depth"]) > 0.5
    assert [(one["rgb"] != other["rgb"]).any() for one, other in pairwise(here)] == [True] * 4
    assert env.trial.plant == trial.plant
    env.close()


PROGRAM = f"""
import gymnasium, lockprobe, numpy as np
settings = dict(observation="rgb", plant="{SMALL}")
pictures = {{}}
for mode in ("sync", "async"):  # the first opens a renderer in this process, from which the second forks
    envs = gymnasium.make_vec("lockprobe/Lockbox-v0", num_envs=2, vectorization_mode=mode, **settings)
    pictures[mode] = [envs.reset(seed=1)[0], envs.step(np.array([3, 0]))[0]]
    if mode == "async":
        envs.close()
assert np.array_equal(pictures["sync"], pictures["async"])
assert (pictures["sync"][0][0] != pictures["sync"][1][0]).any()
print("done")
"""


def test_many_boxes_in_forked_processes_do_not_hang():
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(PROGRAM)], capture_output=True, text=True, check=False, timeout=400
    )
    assert (done.stdout, done.returncode) == ("done\n", 0), done.stderr
