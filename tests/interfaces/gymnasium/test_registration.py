"""Importing the package registers the environment; importing Lockprobe loads no Gymnasium."""

import subprocess
import sys

import pytest

MADE = "env = gymnasium.make('lockprobe/Lockbox-v0'); env.reset(seed=1); env.close()"


@pytest.mark.parametrize(
    "program",
    [
        f"import gymnasium; gymnasium.make('lockprobe.interfaces.gymnasium:lockprobe/Lockbox-v0'); {MADE}",
        "import gymnasium; gymnasium.make('lockprobe:lockprobe/Lockbox-v0').close()",
        f"import lockprobe.interfaces.gymnasium; import gymnasium; {MADE}",
        "import sys; import lockprobe; assert 'gymnasium' not in sys.modules",
    ],
)
def test_it_is_there_once_the_package_is_imported(program):
    """Every warning is an error."""
    done = subprocess.run([sys.executable, "-W", "error", "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
