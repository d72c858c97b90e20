"""Settings and texts are read whole or refused in one line; every language says what English says."""

import re

import numpy as np
import pytest
from pydantic import BaseModel

from lockprobe.foundation.errors import BadFile, UnknownName
from lockprobe.foundation.validation import validated
from lockprobe.interventions.words import TextChannel
from lockprobe.people.experiment import (
    EXPERIMENT,
    LANGUAGES,
    Experiment,
    filled,
    kept_experiment,
    read_experiment,
    read_words,
    words_file,
)
from lockprobe.trial.record import Percept, Task

PYDANTIC = ("Value error", "Input should", "should have", "should match", "Extra inputs", "Field required")
CHECK = '[[checks]]\nafter = 1\nquestion = "q"\n'
QUESTION = '[[questions]]\nname = "a"\nquestion = "q"\n'
ENGLISH = words_file("en").read_text("utf-8")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('practise = ""', "practise: no key is called 'practise' (did you mean 'practice'?); there are: history, device,"),
        ("trials_each = 0", "trials_each: got 0, expected at least 1"),
        ('away_minutes = "x"', "away_minutes: got 'x', expected a number"),
        ('completion_url = "http://x"', "completion_url: got 'http://x', expected pattern '^(https:"),
        (CHECK + 'options = ["a"]\nright = "a"', "checks.0.options: got ['a'], expected at least 2 items"),
        (CHECK + 'options = ["a", "b"]', "checks.0.right: is missing"),
        (CHECK + 'options = ["a", "b"]\nright = "c"', "checks.0: options must be distinct, and right must be one of them"),
        (CHECK + 'options = ["a", "b"]\nright = "a"\nwhen = 1', "checks.0.when: no such key"),
        (QUESTION + QUESTION, "all: two questions have the same name"),
        ("require_id = true\nrecruitment = []", "all: require_id needs a parameter in recruitment"),
    ],
)  # fmt: skip
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


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ('withdraw_yes = "Yes, delete everything"\n', "", "all: page: withdraw_yes is missing"),
        ('next = "Go on"\n', 'next = "Go on"\nremove = "x"\n', "all: no key in page is called 'remove'"),
        ('agree = "I agree to take part"\n', "", "all: page: agree is missing"),
        ("[closed.late]", "[closed.lately]", "all: closed: late is missing"),
        ("[consent]\n", "[consent]\nmore = 1\n", "consent.more: no such key"),
    ],
)
def test_a_text_that_is_missing_or_none_is_named(tmp_path, before, after, said):
    file = tmp_path / "mine.toml"
    file.write_text(ENGLISH.replace(before, after, 1), "utf-8")
    with pytest.raises(BadFile, match=re.escape(f"{file}: {said}")):
        read_words(str(file))


def test_a_text_of_ones_own_is_read_and_an_unknown_language_lists_those_there_are(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(ENGLISH.replace('title = "Open the lockbox"', 'title = "<script>alert(1)</script>"'), "utf-8")
    assert read_words(str(file)).title == "<script>alert(1)</script>"
    with pytest.raises(UnknownName, match="en"):
        read_words("tlh")


def test_what_is_kept_reads_back_and_what_is_no_settings_is_refused(tmp_path):
    assert kept_experiment(tmp_path) is None
    (tmp_path / "people").mkdir()
    kept, settings = tmp_path / "people" / EXPERIMENT, Experiment(feedback=True, trials_each=3)
    kept.write_text(settings.model_dump_json())
    assert kept_experiment(tmp_path) == settings == validated(Experiment, settings.model_dump())
    for text in ("{", "[]", '{"feedback": "film"}', "[" * 100_000):
        kept.write_text(text)
        with pytest.raises(BadFile):
            kept_experiment(tmp_path)


def texts(part, path=()):
    """Every text with the place where it stands."""
    if isinstance(part, BaseModel):
        part = {name: getattr(part, name) for name in type(part).model_fields}
    if isinstance(part, dict | tuple):
        for name, value in part.items() if isinstance(part, dict) else enumerate(part):
            yield from texts(value, (*path, name))
    elif isinstance(part, str):
        yield path, part


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_language_says_what_english_says_with_the_same_names_filled_in(language):
    there, english = (dict(texts(read_words(one))) for one in (language, "en"))
    assert there["language",] == language
    names = [{path: set(re.findall(r"\{(\w+)\}", text)) for path, text in one.items()} for one in (there, english)]
    assert names[0] == names[1]
    same = [path for path, text in there.items() if text == english[path] and len(text) > 12]
    assert same == [] or language == "en"


@pytest.mark.parametrize("outcome", ["moved", "blocked", None])
@pytest.mark.parametrize("positions", [(True, False, True), (False, False, False), None])
def test_in_english_people_are_told_word_for_word_what_models_are_told(outcome, positions):
    labels = ("B", "A", "C")
    percept = Percept(joint="A" if outcome else None, outcome=outcome, positions=positions)
    task = Task(joints=labels, target="A", budget=20)
    told = TextChannel().perceive(percept, (), task, np.random.default_rng(1)).text
    page = read_words("en").page
    said = [filled(page[outcome], label="A")] if outcome else []
    if positions is not None:
        ones = [label for label, position in zip(labels, positions, strict=True) if position]
        said.append(filled(page["positions"], labels=", ".join(ones) or page["none"]))
    assert " ".join(said) == told
