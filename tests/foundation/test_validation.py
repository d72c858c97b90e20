"""What pydantic says is said in plain words."""

from typing import Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_choice, plain

FOREIGN = ("Input", "should", "valid", "unable to parse", "Extra inputs", "Value error", "validation", "Field required")


class Model(BaseModel):
    """Something of every kind."""

    model_config = ConfigDict(extra="forbid")

    whole: int = Field(default=1, ge=1, le=9)
    number: float = 0.0
    text: str = Field(default="", max_length=3)
    names: list[str] = Field(default=["a"], min_length=1)
    yes: bool = True
    one: Literal["a", "b"] = "a"
    table: dict[str, int] = {}


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"whole": "x"}, "expected a whole number"),
        ({"whole": 1.5}, "expected a whole number"),
        ({"whole": 0}, "expected at least 1"),
        ({"whole": 10}, "expected at most 9"),
        ({"number": "x"}, "expected a number"),
        ({"text": 3}, "expected a text"),
        ({"text": "long"}, "expected at most 3 characters"),
        ({"names": "x"}, "expected a list"),
        ({"names": []}, "expected at least 1 item"),
        ({"yes": "x"}, "expected true or false"),
        ({"one": "c"}, "expected 'a' or 'b'"),
        ({"table": 1}, "expected a table"),
        ({"other": 1}, "no such key"),
    ],
)
def test_no_words_of_pydantic(given, said):
    with pytest.raises(ValidationError) as raised:
        Model.model_validate(given)
    found = plain(raised.value.errors()[0]["msg"])
    assert found == said
    assert not [word for word in FOREIGN if word in found]


def test_a_choice_that_does_not_exist_is_refused_with_those_that_do():
    check_choice("luck", "own", ("own", "flip"))
    with pytest.raises(BadValue, match=r"luck: got 'bad', expected one of own, flip"):
        check_choice("luck", "bad", ("own", "flip"))
