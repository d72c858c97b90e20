"""OpenGL without a window; what cannot be had in a process is refused instead of hanging."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

from lockprobe_robot.rendering.opengl import OpenGL

FORKS = """
import os, sys, mujoco
from lockprobe.foundation.errors import BadValue
from lockprobe_robot.rendering.opengl import OpenGL
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><camera name='eye'/></worldbody></mujoco>")
open = lambda: OpenGL(model, width=64, height=64)
def in_a_fork():
    if (child := os.fork()) == 0:
        try:
            open().render(mujoco.MjData(model), "eye")
        except BadValue as refused:
            assert "forked" in str(refused)
            os._exit(3)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
before = in_a_fork()
open()
print(before, in_a_fork())
"""


def test_a_process_forked_before_the_first_look_can_look_and_one_forked_after_it_is_refused(opens):
    """Neither hangs."""
    program = [sys.executable, "-W", "ignore", "-c", FORKS]
    assert subprocess.run(program, capture_output=True, text=True, timeout=300, check=True).stdout == "0 3\n"


def test_the_record_names_the_driver(table, opens):
    name = opens(table).name
    assert name.startswith("egl (mujoco ")
    assert len(name) > len("egl (mujoco 4.0.0, )")


def test_closing_one_leaves_the_others(table, state, opens):
    kept = opens(table)
    before, _ = kept.render(state(table), "above")
    OpenGL(table, width=64, height=64).close()
    after, _ = kept.render(state(table), "above")
    assert before.tobytes() == after.tobytes()


def test_another_thread_can_go_on_with_it(table, state, opens):
    kept = opens(table)
    before, _ = kept.render(state(table), "above")
    with ThreadPoolExecutor(1) as other:
        there, _ = other.submit(kept.render, state(table), "above").result()
    after, _ = kept.render(state(table), "above")
    assert before.tobytes() == there.tobytes() == after.tobytes()
