"""A quickly made dataclass is the dataclass that it was: only the way in which its fields are set is another."""

import pickle
from dataclasses import FrozenInstanceError, dataclass, field, fields, replace
from inspect import signature

import pytest

from lockprobe.foundation.quickly_made import quickly_made


@dataclass(frozen=True, slots=True, kw_only=True)
class Plain:
    first: int
    second: str = "two"
    third: dict[str, int] = field(default_factory=dict)


@quickly_made
@dataclass(frozen=True, slots=True, kw_only=True)
class Quick:
    first: int
    second: str = "two"
    third: dict[str, int] = field(default_factory=dict)


@quickly_made
@dataclass(frozen=True, slots=True)
class Placed:
    first: int = 1
    second: int = 2


def values(one):
    return [getattr(one, part.name) for part in fields(one)]


@pytest.mark.parametrize("given", [{"first": 1}, {"first": 1, "third": {"a": 1}}, {"second": "b", "first": 0}])
def test_it_is_made_copied_and_kept_like_any_other(given):
    plain, quick = Plain(**given), Quick(**given)
    assert values(quick) == values(plain)
    assert values(replace(quick, first=5)) == values(replace(plain, first=5))
    assert pickle.loads(pickle.dumps(quick)) == quick == Quick(**given)
    assert list(signature(Quick).parameters) == list(signature(Plain).parameters)
    with pytest.raises(FrozenInstanceError):
        quick.first = 2


def test_nothing_made_anew_is_shared_and_order_counts_where_it_may():
    assert Quick(first=1).third is not Quick(first=1).third
    assert values(Placed(3)) == [3, 2]


@pytest.mark.parametrize("given", [((), {}), ((1,), {}), ((), {"first": 1, "fourth": 4})])
def test_what_is_missing_unknown_or_without_its_name_is_refused(given):
    places, names = given
    for kind in (Plain, Quick):
        with pytest.raises(TypeError):
            kind(*places, **names)
