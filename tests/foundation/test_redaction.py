"""Secrets of the environment are found however JSON spells them."""

import json

import pytest

from lockprobe.foundation.redaction import without_keys

KEY = "sk-Pri/vate+0123=äB"


@pytest.fixture(autouse=True)
def key(monkeypatch):
    monkeypatch.setenv("FAKE_API_KEY", KEY)


def escaped(text, which=lambda i: True, upper=False):
    codes = (f"{ord(c):04X}" if upper else f"{ord(c):04x}" for c in text)
    return "".join(f"\\u{code}" if which(i) else text[i] for i, code in enumerate(codes))


@pytest.mark.parametrize(
    "spelt",
    [
        KEY,
        escaped(KEY),
        escaped(KEY, upper=True),
        escaped(KEY, lambda i: i % 2),
        json.dumps(KEY)[1:-1],
        KEY.replace("/", "\\/"),
        json.dumps(escaped(KEY))[1:-1],
        json.dumps(json.dumps(escaped(KEY, lambda i: i == 3)))[1:-1],
    ],
)
def test_a_key_is_found_however_json_spells_it(spelt):
    assert without_keys(f'{{"hypothesis": "{spelt}", "joint": "A"}}').count("[secret]") == 1
    assert "0123" not in without_keys(f"x {spelt} y")


def test_other_escapes_stay_and_a_key_that_is_changed_or_taken_away_later_is_noticed_at_once(monkeypatch):
    said = 'a \\u0041 and a \\n, "\\\\", C:\\sk-x'
    assert without_keys(said) == said
    assert without_keys("x later-0123 y") == "x later-0123 y"
    monkeypatch.setenv("OTHER_API_KEY", "later-0123")
    assert without_keys("x later-0123 y") == "x [secret] y"
    monkeypatch.setenv("OTHER_API_KEY", "other-0123")
    assert without_keys("x later-0123 other-0123") == "x later-0123 [secret]"
    monkeypatch.delenv("OTHER_API_KEY")
    assert without_keys("x other-0123 y") == "x other-0123 y"
