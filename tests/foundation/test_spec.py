"""Specs as values, and their options."""

from dataclasses import dataclass, field
from typing import Literal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.spec import (
    Spec,
    arguments_from,
    group_of,
    in_words,
    named_spec,
    options_of,
    settings_of,
    spec_kind,
    spec_name,
    split_specs,
    with_options,
)

NAMES = st.text(st.characters(codec="utf-8", exclude_characters="?"))
KINDS = st.text(st.characters(codec="utf-8", exclude_characters="?:"))
OPTIONS = st.dictionaries(st.text(st.characters(codec="utf-8")), st.text(st.characters(codec="utf-8")))


@settings(max_examples=40)
@given(kind=KINDS, name=NAMES, options=OPTIONS)
def test_a_spec_that_is_written_and_read_is_the_same(kind, name, options):
    spec = Spec(kind, name, options)
    assert Spec.parse(str(spec)) == spec
    assert hash(Spec.parse(str(spec))) == hash(spec)


@given(text=st.text(st.characters(codec="utf-8", exclude_characters="?")), query=st.text("ab=&;%2+/: "))
def test_the_text_of_a_spec_that_was_read_stays_byte_for_byte(text, query):
    for written in (text, f"{text}?{query}"):
        try:
            spec = Spec.parse(written)
        except BadValue:
            continue
        assert str(spec) == written
        assert spec.full_name == spec_name(written)
        assert spec.kind == spec_kind(written)


def test_options_are_added_replaced_and_taken_away():
    spec = Spec.parse("tremble?p=0,1%2E5")
    assert str(spec.adding({"p": "4;8"})) == "tremble?p=4;8"
    assert str(spec.without(["p", "q"])) == "tremble"
    written = str(Spec.parse("manual").adding({"camera": "A&B?/%26 ä"}))
    assert Spec.parse(written).options == {"camera": "A&B?/%26 ä"}


@pytest.mark.parametrize("spec", ["a?x", "a?x=1&x=2", "a?=1&", "a?"])
def test_options_have_a_name_and_a_value_and_come_once(spec):
    with pytest.raises(BadValue, match="^agent: got"):
        Spec.parse(spec)


@pytest.mark.parametrize(
    ("text", "name", "spec"),
    [
        ("lies=flip?p=0.4", "lies", "flip?p=0.4"),
        (" a = drop ", "a", "drop"),
        *((whole, "", whole) for whole in ("drop", "flip?p=0.4", "cognitive:x=y", "a/b=c", "drop + x=y")),
    ],
)
def test_a_name_ends_at_the_first_equals_sign_before_any_mark_of_a_spec(text, name, spec):
    assert named_spec(text, "condition", "lies=flip?p=0.4") == (name, spec)


@pytest.mark.parametrize("text", ["=drop", " =drop", "a=", "a= "])
def test_a_name_and_its_spec_are_both_there(text):
    with pytest.raises(BadValue, match="^condition: got .*, expected NAME=SPEC, for example lies=flip.p=0.4"):
        named_spec(text, "condition", "lies=flip?p=0.4")


def test_specs_are_joined_by_plus_signs_and_a_person_counts_for_all():
    assert split_specs("tremble?p=0.1 + nudge+drop") == ["tremble?p=0.1", "nudge", "drop"]
    spoken = ("participant:3f9a01bc", "participant", "participants", "mcp:x")
    assert [group_of(one) for one in spoken] == ["participant", *spoken[1:]]


@dataclass(frozen=True)
class Many:
    """Fields of every kind."""

    p: float = 0.5
    from_: int | None = None
    at: tuple[int, ...] = ()
    number: float | None = None
    kind: Literal["one", "two"] | None = None
    digest: str = field(init=False, default="")
    _own: int = 3


def test_options_are_named_without_the_underscore_behind_a_word_of_python_and_read_by_type():
    assert [*options_of(Many)] == ["p", "from", "at", "number", "kind"]
    assert with_options(Many, "x", {}) == Many()
    given = {"from": "2", "at": in_words((4, 8)), "number": "1.5", "kind": "two"}
    found = with_options(Many, "x", given)
    assert found == Many(from_=2, at=(4, 8), number=1.5, kind="two")
    assert settings_of(found) == {"p": 0.5, "from": 2, "at": "4;8", "number": 1.5, "kind": "two", "digest": ""}
    for private in ("from_", "digest", "_own"):
        with pytest.raises(UnknownName, match="there are: p, from, at"):
            with_options(Many, "x", {private: "1"})


def test_arguments_of_anybody_s_function_are_read_by_annotation_or_default():
    def written(box, *, size: "int", share=0.5, loud=False, word=None, many: int | None = None):
        return size

    class Made:
        def __init__(self, rng: "not_there.Generator" = None, lag: "int" = 1):  # noqa: F821
            self.lag = lag

    given = {"size": "3", "share": "1", "loud": "yes", "word": "5", "many": "7"}
    read = arguments_from(written, "written", given, ["box"])
    assert read == {"size": 3, "share": 1.0, "loud": True, "word": "5", "many": 7}
    assert arguments_from(Made, "made", {"lag": "2"}) == {"lag": 2}
    with pytest.raises(UnknownName, match="no option of written is called 'box'"):
        arguments_from(written, "written", {"box": "x"}, ["box"])
    with pytest.raises(BadValue, match="^loud: got 'true', expected yes or no"):
        arguments_from(written, "written", {"loud": "true"})
