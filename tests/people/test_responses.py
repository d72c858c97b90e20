"""An answer is one to its question."""

import pytest

from lockprobe.people.responses import Answer, fits
from lockprobe.people.scenes import Ask


def taken(answer, **question):
    return fits(Ask(name="age", question="How old are you?", **question), Answer(answer=answer, rt=1.0))


@pytest.mark.parametrize(
    "answer", ["banana", "1e9", "nan", "inf", "17", "121", "18.5", "-20", "0x20", "१८", "1_8", "9" * 40]
)
def test_what_is_no_age_is_refused(answer):
    assert not taken(answer, type="integer", low=18, high=120)


@pytest.mark.parametrize("answer", ["18", " 34 ", "120", "+40"])
def test_an_age_is_taken(answer):
    assert taken(answer, type="integer", low=18, high=120)


@pytest.mark.parametrize("answer", ["1.5", "1,5", "-3"])
def test_numbers_are_written_as_people_write_them(answer):
    assert taken(answer, type="number")


def test_options_and_required_answers_are_as_before():
    assert taken("")
    assert not taken(" ", required=True)
    assert taken("a", options=("a", "b"))
    assert not taken("c", options=("a", "b"))
    assert taken("banana")
