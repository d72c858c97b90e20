"""What participants read is whole in every language that ships, and the same in kind."""

import re

import numpy as np
import pytest
from pydantic import BaseModel

from lockprobe.foundation.errors import BadFile, UnknownName
from lockprobe.interventions.words import TextChannel
from lockprobe.people.texts import _TEXTS, LANGUAGES, example_on, filled, read_words
from lockprobe.trial.record import Percept, Task


def texts(part, path=()):
    """Every text with the place where it stands."""
    if isinstance(part, BaseModel):
        part = {name: getattr(part, name) for name in type(part).model_fields}
    if isinstance(part, dict):
        for name, value in part.items():
            yield from texts(value, (*path, name))
    elif isinstance(part, tuple):
        for i, value in enumerate(part):
            yield from texts(value, (*path, i))
    elif part is not None:
        yield path, part


def names(text):
    return sorted(set(re.findall(r"\{(\w+)\}", text)))


def test_german_ships_beside_english():
    assert {"de", "en"} <= set(LANGUAGES)


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_language_says_what_english_says_with_the_same_names_filled_in(language):
    there, english = dict(texts(read_words(language))), dict(texts(read_words("en")))
    assert there["language",] == language
    assert {path: names(text) for path, text in there.items()} == {path: names(text) for path, text in english.items()}


@pytest.mark.parametrize("language", set(LANGUAGES) - {"en"})
def test_nothing_is_left_in_english(language):
    there, english = dict(texts(read_words(language))), dict(texts(read_words("en")))
    same = [path for path, text in there.items() if text == english[path] and len(text) > 12 and path[-1] != "only"]
    assert same == []


@pytest.mark.parametrize("outcome", ["moved", "blocked", None])
@pytest.mark.parametrize("positions", [(True, False, True), (False, False, False), None])
def test_in_english_people_are_told_word_for_word_what_models_are_told(outcome, positions):
    labels = ("B", "A", "C")
    percept = Percept(joint="A" if outcome else None, outcome=outcome, positions=positions)
    task = Task(joints=labels, target="A", budget=20)
    told = TextChannel().perceive(percept, (), task, np.random.default_rng(1)).text
    page = read_words("en").page
    said = [filled(page.moved if outcome == "moved" else page.blocked, label="A")] if outcome else []
    if positions is not None:
        ones = [label for label, position in zip(labels, positions, strict=True) if position]
        said.append(filled(page.positions, labels=", ".join(ones) or page.none))
    assert " ".join(said) == told


def test_a_missing_text_is_named(tmp_path):
    file = tmp_path / "mine.toml"
    english = (_TEXTS / "en.toml").read_text()
    file.write_text(english.replace('withdraw_yes = "Yes, delete everything"\n', ""))
    with pytest.raises(BadFile, match=r"page\.withdraw_yes"):
        read_words(str(file))


def test_a_text_of_ones_own_is_read(tmp_path):
    file = tmp_path / "mine.toml"
    english = (_TEXTS / "en.toml").read_text()
    file.write_text(english.replace('title = "Open the lockbox"', 'title = "<script>alert(1)</script>"'))
    assert read_words(str(file)).title == "<script>alert(1)</script>"


def test_an_example_is_on_the_first_two_pages_or_where_the_texts_say():
    words = read_words("en")
    one = words.instructions[0]

    def shown(*pages):
        of = words.model_copy(update={"instructions": pages})
        return [example_on(of, number) for number in range(1, len(pages) + 1)]

    assert shown(one, one, one) == ["box", "step", "none"]
    assert shown(one) == ["step"]
    assert shown(one.model_copy(update={"example": "none"}), one, one.model_copy(update={"example": "box"})) == [
        "none", "step", "box"
    ]  # fmt: skip


def test_an_unknown_language_lists_those_there_are():
    with pytest.raises(UnknownName, match="en"):
        read_words("tlh")


def test_what_is_no_fact_stays_as_it_is():
    assert filled("{a} {b} {{a}}", a=1) == "1 {b} {1}"
