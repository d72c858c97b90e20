"""What is wrong with a file is said as every other mistake is."""

import pytest

from lockprobe.foundation.errors import BadFile
from lockprobe.people.experiment import Experiment, read_experiment
from lockprobe.people.file_errors import check_visible
from lockprobe.people.texts import _TEXTS, read_words

PYDANTIC = ("Value error", "Input should", "should have", "should match", "Extra inputs", "Field required")

CHECK = '[[checks]]\nafter = 1\nquestion = "q"\n'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            'desing = "within"',
            "desing: no key is called 'desing' (did you mean 'design'?); there are: history, history_open,",
        ),
        ('design = "film"', "design: got 'film', expected 'within' or 'between'"),
        ("trials_each = 0", "trials_each: got 0, expected greater than or equal to 1"),
        ('away_minutes = "x"', "away_minutes: got 'x', expected number"),
        ('completion_url = "http://x"', "completion_url: got 'http://x', expected pattern '^(https:"),
        (CHECK + 'options = ["a"]\nright = "a"', "checks.0.options: got ['a'], expected at least 2 items"),
        (CHECK + 'options = ["a", "b"]', "checks.0.right: is missing"),
        (
            CHECK + 'options = ["a", "b"]\nright = "c"',
            "checks.0: options must be distinct, and right must be one of them",
        ),
        (CHECK + 'options = ["a", "b"]\nright = "a"\nwhen = 1', "there are: question, options, right, after"),
        (f'practice = "{"x" * 9999}"', "practice: got 'xxx"),
    ],
)
def test_it_is_said_where_what_came_and_what_is_allowed(tmp_path, text, said):
    file = tmp_path / "people.toml"
    file.write_text(text)
    with pytest.raises(BadFile) as mistake:
        read_experiment(file)
    message = str(mistake.value)
    assert message.startswith(f"{file}: ")
    assert said in message
    assert not any(phrase in message for phrase in PYDANTIC)
    assert len(message) < len(str(file)) + 600


def test_texts_too(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text((_TEXTS / "en.toml").read_text() + 'remove = "x"\n')
    with pytest.raises(BadFile, match=r"page\.remove: no key is called 'remove'.*; there are: next, begin"):
        read_words(str(file))


@pytest.mark.parametrize("character", ["\x00", "\x1b", "\x07", "\x7f", "\x9b", "\r", "\ud800"])
def test_what_nobody_sees_is_no_text(character):
    with pytest.raises(ValueError, match=f"U\\+{ord(character):04X}"):
        check_visible(f"a{character}b")


def test_other_scripts_and_lines_are_texts():
    for text in ("\u202b\u05e9\u05dc\u202c", "a\nb\tc", "👩\u200d🔬", ""):
        assert check_visible(text) == text


@pytest.mark.parametrize("escaped", ["\\u0000", "\\u001b"])
def test_no_file_brings_it_in(tmp_path, escaped):
    texts, people = tmp_path / "texts.toml", tmp_path / "people.toml"
    texts.write_text((_TEXTS / "en.toml").read_text().replace('title = "Open the', f'title = "Open{escaped}the', 1))
    with pytest.raises(BadFile, match=r"title: holds the control character U\+00"):
        read_words(str(texts))
    for setting in (
        f'completion_code = "a{escaped}b"',
        f'[[questions]]\nname = "a"\nquestion = "a{escaped}b"',
        f'[[questions]]\nname = "a"\nquestion = "a"\noptions = ["a{escaped}b"]',
    ):
        people.write_text(setting)
        with pytest.raises(BadFile, match=r"holds the control character U\+00"):
            read_experiment(people)


@pytest.mark.parametrize("option", [" red", "red ", "\u00a0red", " ", "red\n"])
def test_an_option_that_only_looks_like_another_is_refused(option):
    for part in (
        {"checks": [{"after": 0, "question": "q", "options": [option, "b"], "right": option}]},
        {"questions": [{"name": "a", "question": "q", "options": [option, "b"]}]},
        {"questions": [{"name": "a", "question": option}]},
    ):
        with pytest.raises(ValueError, match="without space around them"):
            Experiment.model_validate(part)
