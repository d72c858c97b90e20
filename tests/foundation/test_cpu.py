"""The name of the processor."""

from pathlib import Path

import pytest

from lockprobe.foundation.cpu import cpu_model


@pytest.fixture(autouse=True)
def anew():
    cpu_model.cache_clear()
    yield
    cpu_model.cache_clear()


@pytest.mark.parametrize(
    ("listed", "model"),
    [
        ("processor\t: 0\nvendor_id\t: GenuineIntel\nmodel name\t: Xeon: Gold\n", "Xeon: Gold"),
        ("processor\t: 0\nBogoMIPS\t: 48.00\n\nModel\t\t: Raspberry Pi 4\n", "Raspberry Pi 4"),
        ("model name\t:\n", "machine"),
        ("model name\t: " + 300 * "x", 120 * "x"),
    ],
)
def test_it_is_named_as_its_maker_does(monkeypatch, listed, model):
    monkeypatch.setattr(Path, "read_text", lambda *_: listed)
    monkeypatch.setattr("platform.processor", lambda: "")
    monkeypatch.setattr("platform.machine", lambda: "machine")
    assert cpu_model() == model


def test_without_a_list_it_is_the_architecture(monkeypatch):
    def none(*_):
        raise FileNotFoundError

    monkeypatch.setattr(Path, "read_text", none)
    assert cpu_model()
