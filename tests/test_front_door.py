"""What ``import lockprobe`` offers, and what it costs."""

import subprocess
import sys
from importlib import import_module

import lockprobe


def test_every_name_is_there_and_only_once_thought_of():
    assert list(lockprobe.__all__) == sorted(set(lockprobe.__all__))
    assert 25 <= len(lockprobe.__all__) <= 32
    for name in lockprobe.__all__:
        thing = getattr(lockprobe, name)
        home = getattr(thing, "__module__", "lockprobe")
        assert home.startswith("lockprobe")
        assert not any(part.startswith("_") for part in home.split("."))
    assert set(lockprobe.__all__) <= set(dir(lockprobe))


def test_names_are_those_of_their_modules():
    assert lockprobe.box is import_module("lockprobe.lockbox.families").find_box
    assert lockprobe.Plant is import_module("lockprobe.protocols").Plant
    assert lockprobe.tidy is import_module("lockprobe.export.tidy").tidy


def test_the_door_is_quick():
    """Only what announces the environment is imported, and no class of it before it is asked for."""
    code = (
        "import sys, lockprobe; dir(lockprobe); "
        "print(sorted({'numpy', 'pydantic', 'asyncio', 'importlib.metadata', 'lockprobe.record', 'lockprobe.trial'}"
        " & sys.modules.keys())); lockprobe.Joint; lockprobe.UserMistake; print('numpy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["[]", "False"]


def test_a_box_is_had_by_name_path_or_object(tmp_path):
    from lockprobe.lockbox.boxfile import toml_of

    fork = lockprobe.box("fork")
    (tmp_path / "mine.toml").write_text(toml_of(fork), "utf-8")
    for asked in ("fork", fork, tmp_path / "mine.toml", str(tmp_path / "mine.toml")):
        assert lockprobe.box(asked) == fork
        assert lockprobe.run_trial(box=asked).box == "fork"
        assert lockprobe.propagate("human-inspired", asked, p=0.0).solved[-1] == 1.0
