"""A quickly made dataclass is the dataclass that it was."""

import pickle
from dataclasses import FrozenInstanceError, asdict, dataclass, field, replace

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


@pytest.mark.parametrize("given", [{"first": 1}, {"first": 1, "third": {"a": 1}}, {"second": "b", "first": 0}])
def test_it_is_made_copied_and_kept_like_any_other_and_stays_as_it_is(given):
    quick = Quick(**given)
    assert asdict(quick) == asdict(Plain(**given))
    assert asdict(replace(quick, first=5)) == asdict(replace(Plain(**given), first=5))
    assert pickle.loads(pickle.dumps(quick)) == quick == Quick(**given)
    assert Quick(first=1).third is not Quick(first=1).third
    with pytest.raises(FrozenInstanceError):
        quick.first = 2
    for wrong in ({}, {"first": 1, "fourth": 4}):
        with pytest.raises(TypeError):
            Quick(**wrong)
