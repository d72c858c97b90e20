"""Tests say the same whoever starts them."""

import asyncio
import fcntl
import gc
import inspect
import os
import signal
from contextlib import ExitStack
from pathlib import Path

import pytest
from _pytest.doctest import DoctestModule
from hypothesis import settings

# A job in the background ignores Ctrl-C, and so would the commands that tests start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# How long an example takes says how busy the machine is.
settings.register_profile("any machine", deadline=None, database=None, max_examples=40)
settings.load_profile("any machine")

# Several workers share the cores: threads of each that wait for more work by spinning only take them away.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Providers in tests are on loopback, without TLS: a client need not read all certificates of the machine, twice.
os.environ["SSL_CERT_FILE"] = str(Path(__file__).with_name("certificate.pem"))

gc.disable()  # until all is collected

ROOMS = Path(__file__).parent


def pytest_ignore_collect(collection_path):
    """Modules of the package are imported for their examples, if they hold any."""
    if collection_path.suffix == ".py" and not collection_path.is_relative_to(ROOMS):
        return ">>>" not in collection_path.read_text("utf-8") or None
    return None


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """In a fresh clone one worker compiles all modules and the others wait: each would take twenty seconds for them."""
    compiled = ROOMS / "__pycache__"
    with ExitStack() as alone:
        if "PYTEST_XDIST_WORKER" in os.environ and compiled.is_dir():
            fcntl.flock(alone.enter_context((compiled / "collecting.lock").open("w")), fcntl.LOCK_EX)
            if any(compiled.glob("test_*.pyc")):
                alone.close()
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_collect_file(file_path):
    """Docstrings of tests hold no examples: only those of the package are looked through."""
    found = yield
    return [part for part in found if not (isinstance(part, DoctestModule) and file_path.is_relative_to(ROOMS))]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Tests in a browser come first: they mostly wait, and at the end nothing else would be left to do meanwhile."""
    items.sort(key=lambda item: not item.nodeid.startswith("tests/people/web/"))


def pytest_collection_finish():
    """What was imported and collected stays to the end: the collector need not look through it again and again."""
    gc.freeze()
    gc.enable()
    gc.set_threshold(50_000, 20, 20)  # thousands of trials are made here, and few objects in circles


@pytest.fixture(scope="module")
def placeholders():
    """Figures take seconds, and where this is used none is looked at."""
    from placeholders import undrawn

    with undrawn():
        yield


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem):
    """A test that is a coroutine runs in a loop of its own."""
    if not inspect.iscoroutinefunction(pyfuncitem.obj):
        return None
    given = {name: pyfuncitem.funcargs[name] for name in inspect.signature(pyfuncitem.obj).parameters}
    asyncio.run(pyfuncitem.obj(**given))
    return True
