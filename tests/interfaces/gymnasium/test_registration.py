"""Gymnasium knows the environment, whichever is imported first, and is not loaded for those who do not use it."""

import subprocess
import sys

import gymnasium
import pytest

from lockprobe.interfaces.gymnasium import ENVIRONMENT, announce, register

MADE = "env = gymnasium.make('lockprobe/Lockbox-v0'); env.reset(seed=1); env.close()"


def fresh(program):
    """Runs a program in a fresh interpreter in which every warning is an error."""
    return subprocess.run([sys.executable, "-W", "error", "-c", program], capture_output=True, text=True, check=False)


WAITING = f"""
import importlib.util, sys
import lockprobe
assert "gymnasium" not in sys.modules
before = len(sys.meta_path)
assert importlib.util.find_spec("gymnasium").name == "gymnasium"  # somebody only asks whether it is there
import gymnasium
assert len(sys.meta_path) == before - 1
lockprobe.interfaces.gymnasium.announce()
{MADE}
"""


@pytest.mark.parametrize(
    "program",
    [
        f"import gymnasium; gymnasium.make('lockprobe:lockprobe/Lockbox-v0'); import lockprobe; {MADE}",
        WAITING,
    ],
)
def test_it_is_there_in_any_order_of_imports(program):
    done = fresh(program)
    assert (done.returncode, done.stderr) == (0, "")


def test_without_gymnasium_the_rest_is_usable():
    done = fresh(
        "import sys; sys.modules['gymnasium'] = None\n"
        "import lockprobe.interfaces.gymnasium.learned_agent\n"
        "try:\n    import gymnasium\nexcept ImportError:\n    print('none')"
    )
    assert (done.stdout, done.stderr) == ("none\n", "")


def test_registering_again_changes_nothing():
    before = gymnasium.registry[ENVIRONMENT]
    register()
    announce()
    assert gymnasium.registry[ENVIRONMENT] is before
