"""The lockbox as data, with its one rule.

Attempting a joint toggles it if the interlock allows it in the present configuration, else nothing
happens (paper, Sec. 2.1). The real box's interlock is not public, so a box is data, never hard-coded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, GetPydanticSchema, PlainSerializer, TypeAdapter

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_choice

Configuration = tuple[bool, ...]
"""One position per joint in panel order; False is closed."""

MAX_JOINTS = 8
"""Largest number of joints, one for each label."""

Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,39}$")]
"""The name of a box or a joint, as a file can hold it."""

_Bit = Annotated[Literal[0, 1], AfterValidator(bool), PlainSerializer(int)]

Clause = Mapping[Name, Annotated[bool, GetPydanticSchema(lambda _, handler: handler(_Bit))]]
"""Positions of other joints that must all hold; in a file 0 or 1."""

_Unit = Annotated[float, Field(ge=0, le=1), PlainSerializer(float)]

_NO_OTHER_KEYS = ConfigDict(extra="forbid")

JointKind = Literal["prismatic", "revolute"]

LayoutKind = Literal["fixed", "dealt", "shuffled"]
"""The panel: the box's own; joints dealt to its places once for a study; or anew in every trial."""

Shuffle = Literal["trial", "study", "never"]
"""How often labels and the order of their list are drawn: in every trial, once for a study, or not at all."""


def bits(configuration: Configuration) -> str:
    """A configuration as a bit string in panel order, for example ``"0010"``."""
    return "".join(map("01".__getitem__, configuration))


def _from_bits(said: object) -> Configuration:
    if isinstance(said, str) and {*said} <= {"0", "1"}:
        return tuple(map("1".__eq__, said))
    raise ValueError("expected a 0 or 1 for each joint, in quotes")


@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    """One moving part on the panel, which slides or turns. The agent never sees its name.

    ``place`` is in panel widths from the left and panel heights from below, [0, 1]. Joints that all lie at one place
    are laid in a row by their box.
    """

    __pydantic_config__ = _NO_OTHER_KEYS

    name: Name
    kind: JointKind
    place: tuple[_Unit, _Unit] = (0.5, 0.5)


@dataclass(frozen=True, slots=True, kw_only=True)
class Lockbox:
    """A lockbox: joints in panel order, left to right, interlock, initial configuration, and the target that opens it.

    Attributes:
        interlock: For each joint the clauses under which it may move (disjunctive normal form): it moves if *any*
            clause holds *entirely*. A joint that is always free has one empty clause and may be left out.
    """

    __pydantic_config__ = _NO_OTHER_KEYS

    name: Name
    joints: Annotated[tuple[Joint, ...], Field(min_length=2)]
    interlock: Annotated[
        Mapping[Name, Annotated[tuple[Clause, ...], Field(min_length=1, max_length=32)]], Field(default_factory=dict)
    ]
    initial: Annotated[Configuration, BeforeValidator(_from_bits), PlainSerializer(bits)]
    target: Name

    def __post_init__(self) -> None:
        names = self.names
        if len(set(names)) != len(names):
            raise BadValue("joints", list(names), "every name once")
        check_choice("target", self.target, names)
        if len(names) > MAX_JOINTS:
            raise BadValue("joints", len(names), f"at most {MAX_JOINTS}")
        if not all(position in (True, False) for position in self.initial):
            raise BadValue("initial", self.initial, "positions True (open) and False, in panel order")
        if len(self.initial) != len(names):
            raise BadValue("initial", bits(self.initial), f"one position for each of {len(names)} joints")
        self._check_interlock(names)
        if len({joint.place for joint in self.joints}) == 1:  # nobody has said where they lie
            row = [(round((i + 0.5) / len(names), 3), 0.5) for i in range(len(names))]
            joints = tuple(replace(joint, place=place) for joint, place in zip(self.joints, row, strict=True))
            object.__setattr__(self, "joints", joints)

    def _check_interlock(self, names: Sequence[str]) -> None:
        for joint, clauses in self.interlock.items():
            if not isinstance(clauses, tuple) or not all(isinstance(clause, Mapping) for clause in clauses):
                raise BadValue(f"interlock of {joint}", clauses, "a tuple of clauses, each joint -> position")
            check_choice("interlock", joint, names)
            if not clauses:
                raise BadValue(f"interlock of {joint}", clauses, "a clause at least, without which it never moves")
            for other in (name for clause in clauses for name in clause):
                if other not in names or other == joint:
                    expected = f"positions of other joints: {', '.join(name for name in names if name != joint)}"
                    raise BadValue(f"interlock of {joint}", other, expected)

    @property
    def names(self) -> tuple[str, ...]:
        """Joint names in panel order."""
        return tuple([joint.name for joint in self.joints])

    @property
    def target_index(self) -> int:
        """Index of the target joint in panel order."""
        return self.names.index(self.target)

    def alternatives(self, joint: str) -> tuple[Clause, ...]:
        """The clauses of a joint (by name); empty if it is always free."""
        clauses = self.interlock.get(joint, ())
        return tuple(clauses) if all(clauses) else ()

    def may_move(self, configuration: Configuration, joint: int) -> bool:
        """Whether the interlock lets a joint (by index in panel order) move in a configuration."""
        at = {one.name: position for one, position in zip(self.joints, configuration, strict=True)}
        clauses = self.interlock.get(self.joints[joint].name, ({},))
        return any(all(at[other] == position for other, position in clause.items()) for clause in clauses)

    def attempt(self, configuration: Configuration, joint: int) -> tuple[Configuration, bool]:
        """Attempt a joint (by index in panel order): the configuration afterwards, and whether the joint moved.

        Only the attempted joint can change.
        """
        if not self.may_move(configuration, joint):
            return configuration, False
        return (*configuration[:joint], not configuration[joint], *configuration[joint + 1 :]), True


@cache
def box_schema() -> TypeAdapter[Lockbox]:
    """What reads boxes from data, and makes data of them."""
    return TypeAdapter(Lockbox)


def data_of(box: Lockbox) -> dict[str, Any]:
    """The box as JSON data; positions are 0 and 1."""
    found: dict[str, Any] = box_schema().dump_python(box, mode="json")
    return found
