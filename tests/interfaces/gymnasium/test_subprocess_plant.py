"""A plant in another process is the same plant; and pictures in forked processes do not hang."""

import subprocess
import sys
import textwrap

import numpy as np
import pytest

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import PlantFault, UserMistake
from lockprobe.interfaces.gymnasium import subprocess_plant
from lockprobe.interfaces.gymnasium.subprocess_plant import SubprocessPlant, needs_subprocess
from lockprobe.plants.symbolic import SymbolicPlant

LABELS = tuple("ABCD")


SMALL = "fast-twin?width=64&height=64&renderer=rays"


def remote(spec="symbolic"):
    return SubprocessPlant(spec, box("chain-4"), LABELS, np.random.default_rng(0))


@pytest.fixture(scope="module", autouse=True)
def ended():
    """All plants of this file share one process, as those of a study do."""
    yield
    if (host := subprocess_plant._Host.running) is not None:
        host.end()


def test_it_is_the_same_plant():
    here, there = SymbolicPlant(box("chain-4")), remote()
    assert there.facts == here.facts
    for joint in (None, 0, 3, 2, 2, 1, 0):
        ours, theirs = (plant.observe() if joint is None else plant.attempt(joint) for plant in (here, there))
        assert ours == theirs
        assert theirs.look is None
    there.close()


def test_plants_share_a_process_and_not_their_state():
    first, second = remote(), remote()
    assert first._host is second._host
    first.attempt(3)
    assert first.observe().configuration != second.observe().configuration
    first.close()
    assert second.attempt(3).outcome == "moved"


def test_who_rendered_it_is_known_once_it_was_looked_at_and_remembered():
    plant = remote(SMALL)
    first = plant.facts
    assert (first["width"], first["renderer"]) == (64, None)
    plant.observe()
    assert plant.facts == first
    plant.attempt(3).look()
    named = dict(plant.facts)
    assert named["renderer"]
    assert named | {"renderer": None} == first
    plant.close()
    plant.close()
    assert plant.facts == named
    other = remote(SMALL)
    other.observe().look()
    other.close()  # nobody asked before
    assert other.facts == named


def test_it_can_be_drawn_as_it_is_not():
    plant = remote(SMALL)
    first = plant.observe()
    assert (first.render((True,) * 4).rgb != first.look().rgb).any()
    assert (first.render(first.configuration).rgb == first.look().rgb).all()
    plant.close()


def test_what_is_wrong_there_is_said_here():
    with pytest.raises(UserMistake, match="^no plant is called 'metal'"):
        remote("metal")
    plant = remote()
    with pytest.raises(PlantFault, match="^IndexError: "):
        plant.attempt(9)
    assert plant.attempt(3).outcome == "moved"  # and it goes on


def test_a_process_that_ends_is_a_fault_and_the_next_plant_gets_another():
    plant, facts = remote(SMALL), remote(SMALL).facts
    plant._host._process.kill()
    assert plant.facts == facts  # what it is remains known
    with pytest.raises(PlantFault, match="the plant's process ended"):
        plant.attempt(0)
    assert plant.facts == facts
    plant.close()
    assert remote().attempt(3).outcome == "moved"


def run(program):
    """A program in a fresh interpreter. Its limit is far above what it takes: it is for what hangs."""
    return subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, check=False, timeout=300
    )


def test_only_a_fork_of_a_process_that_has_opengl_needs_it():
    assert not needs_subprocess()
    done = run("""
        import os
        from lockprobe.interfaces.gymnasium import subprocess_plant
        def in_a_fork():
            if (child := os.fork()) == 0:
                os._exit(10 + subprocess_plant.needs_subprocess())
            return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) - 10
        before, subprocess_plant._opengl_is_loaded = in_a_fork(), lambda: True
        print(before, in_a_fork(), subprocess_plant.needs_subprocess())
    """)
    assert (done.stdout, done.stderr) == ("0 1 False\n", "")


PROGRAM = """
import gymnasium, lockprobe, numpy as np
settings = dict(observation="rgb", plant="fast-twin?width=64&height=64&looks=varied&depth_noise=0.001", max_steps=2)
pictures, plants = {}, {}
for mode in ("sync", "async"):  # the first opens a renderer in this process, from which the second forks
    envs = gymnasium.make_vec("lockprobe/Lockbox-v0", num_envs=2, vectorization_mode=mode, **settings)
    pictures[mode] = [envs.reset(seed=1)[0], *(envs.step(np.array([3, 0]))[0] for _ in range(2))]
    plants[mode] = [trial.plant for trial in envs.get_attr("trial")]
    if mode == "async":
        envs.close()
assert np.array_equal(pictures["sync"], pictures["async"])
assert (pictures["sync"][0][0] != pictures["sync"][1][0]).any()
assert plants["sync"] == plants["async"], plants
assert plants["sync"][0]["renderer"], plants
print("done")
"""


def test_many_boxes_in_forked_processes_show_the_same_and_do_not_hang():
    done = run(PROGRAM)
    assert (done.stdout, done.returncode) == ("done\n", 0), done.stderr
