"""The plant ``manual``: a person moves the joint that the agent names, and says what happened.

The truth is the person's answer, or what a :class:`Sight` reads from a picture (``manual?camera=FOLDER`` of
lockprobe-robot). The person sees the agent's label and the name of the joint in the box. The plant needs a terminal, so
its trials are played in this process, one at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.foundation.errors import PlantFault
from lockprobe.plants.operator import ENTER, Operator, ask_to_begin
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.record import Fact, Snapshot
from lockprobe.trial.told_outcome import in_words


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """What a picture shows.

    Attributes:
        configuration: The positions of the joints, in panel order.
        look: Returns the picture as a frame.
    """

    configuration: Configuration
    look: Callable[[], Frame]


class Sight(Protocol):
    """Reads the positions of the joints from pictures, in the place of the person's answer."""

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Facts for the record, such as the kind of camera."""
        ...

    @property
    def scene(self) -> str:
        """What the person is asked to set up before a trial, as a sentence."""
        ...

    def read(self, names: tuple[str, ...]) -> Seen:
        """Take a new picture and read it.

        Args:
            names: The joints in panel order, for the message.

        Raises:
            PlantFault: If there is no new picture, or it shows no clear position of a joint. The person is asked for
                another one.
        """
        ...

    def close(self) -> None:
        """Release the camera."""
        ...


class Manual:
    """A box in front of a person.

    The trial begins when the person says that the box stands in its initial configuration.

    Args:
        box: The box. Its rules only detect typing errors; they decide no outcome.
        labels: Labels of the joints, in panel order.
        operator: The person.
        sight: Reads the truth from pictures; None if the person tells it.
    """

    def __init__(
        self,
        box: Lockbox,
        *,
        labels: tuple[str, ...],
        operator: Operator,
        sight: Sight | None = None,
    ) -> None:
        self._box, self._operator, self._sight = box, operator, sight
        self._called = [f"{label} ({name})" for label, name in zip(labels, box.names, strict=True)]
        self._configuration: Configuration | None = None
        self._seen: Seen | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        """The source of the truth."""
        return {"truth": "person"} if self._sight is None else {"truth": "camera", **self._sight.facts}

    def observe(self) -> Snapshot:
        """The truth now; before the first attempt the person is asked to set the box up.

        Raises:
            UserMistake: If the person stops here: no trial has begun.
        """
        if self._configuration is None:
            self._set_up()
        assert self._configuration is not None
        return Snapshot(configuration=self._configuration, look=self._look())

    def attempt(self, joint: int) -> Snapshot:
        """Let the person attempt a joint, by index in panel order.

        Raises:
            OperatorStopped: If the person stops, or the input ends.
            PlantFault: If the picture shows that another joint moved.
        """
        before = self._configuration
        assert before is not None
        ends = f"from {before[joint]:d} to {not before[joint]:d}"
        if self._sight is None:
            after = self._typed(joint, before, ends)
        else:
            after = self._photographed(
                f"Move joint {self._called[joint]} {ends} if it goes. Take a picture, then press Enter; q to stop:",
                lambda seen: "",
            )
            others = [i for i, (was, now) in enumerate(zip(before, after, strict=True)) if was != now and i != joint]
            if others:
                moved = ", ".join(self._called[i] for i in others)
                states = f"{bits(before)} became {bits(after)}"
                raise PlantFault(f"{self._called[joint]} was attempted and {moved} moved: {states}")
            did = in_words(after[joint] != before[joint])
            self._operator.tell(f"The picture shows {bits(after)}: {self._called[joint]} {did}.")
        self._configuration = after
        obeyed = after == self._box.attempt(before, joint)[0]
        return Snapshot(
            configuration=after,
            joint=joint,
            outcome="moved" if after[joint] != before[joint] else "blocked",
            sensed={"truth": "person" if self._sight is None else "camera", "as_rules": obeyed},
            look=self._look(),
        )

    def close(self) -> None:
        """Release the camera."""
        if self._sight is not None:
            self._sight.close()

    def _set_up(self) -> None:
        """Ask the person to set the initial configuration, and verify it."""
        initial = self._box.initial
        stand = ", ".join(f"{called} at {at:d}" for called, at in zip(self._called, initial, strict=True))
        if self._sight is None:
            self._operator.tell(f"New trial of {self._box.name}. Set the joints: {stand}.")
            ask_to_begin(self._operator)
        else:
            self._operator.tell(f"New trial of {self._box.name}. {self._sight.scene}")
            self._operator.tell(f"Set the joints: {stand}.")
            self._photographed("Take a picture, then press Enter; q to stop:", self._wrongly_set, begin=True)
        self._configuration = initial

    def _wrongly_set(self, seen: Configuration) -> str:
        """The joints in a wrong position, in words; empty if all are right."""
        wrong = [
            f"{called} at {wanted:d}"
            for called, wanted, found in zip(self._called, self._box.initial, seen, strict=True)
            if wanted != found
        ]
        return f"The picture shows {bits(seen)}: set {', '.join(wrong)}." if wrong else ""

    def _typed(self, joint: int, before: Configuration, ends: str) -> Configuration:
        """Ask what happened; an answer that violates the rules is confirmed by asking again."""
        called, rule = self._called[joint], self._box.may_move(before, joint)
        moved = self._operator.ask(f"Move joint {called} {ends}. Did it move? y/n, q to stop:", ("y", "n")) == "y"
        if moved != rule:
            says = "free" if rule else "locked"
            again = f"By the rules of {self._box.name} {called} is {says}. Did it really move? y/n, q to stop:"
            moved = self._operator.ask(again, ("y", "n")) == "y"
        return tuple(at != (moved and i == joint) for i, at in enumerate(before))

    def _photographed(
        self, question: str, complaint: Callable[[Configuration], str], *, begin: bool = False
    ) -> Configuration:
        """Ask for a picture until one can be read and passes the check."""
        assert self._sight is not None
        while True:
            if begin:
                ask_to_begin(self._operator, question)
            else:
                self._operator.ask(question, (ENTER,))
            try:
                seen = self._sight.read(tuple(self._called))
            except PlantFault as fault:
                self._operator.tell(f"{fault}.")
                continue
            if wrong := complaint(seen.configuration):
                self._operator.tell(wrong)
                continue
            self._seen = seen
            return seen.configuration

    def _look(self) -> Callable[[], Frame] | None:
        """A function that returns the picture of this moment."""
        return None if self._seen is None else self._seen.look
