"""Local language models: the embedded model, and any GGUF file.

They play from a growing log of everything they are told, worded as in the record. They do not generate text: where a
reply leaves a choice, the allowed answers are scored exactly and one is drawn from the random stream of the trial. So
replies are always well formed, the probability of every joint is known, and the same seed gives the same trial on one
machine. Figures stand in ``docs/models.md``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from lockprobe.agents import weights
from lockprobe.agents.policy import draw, refuse_pictures
from lockprobe.agents.prompt import example, fingerprint
from lockprobe.agents.reply import CLAIMS
from lockprobe.foundation.errors import BadValue, Conflict
from lockprobe.foundation.spec import Spec, arguments_from
from lockprobe.trial.record import Decision, Fact, Situation

if TYPE_CHECKING:
    from lockprobe.agents.engine import Engine

_PROBLEM = """\
A lockbox has several joints. Each joint has two positions, 0 and 1. The joints lock each other in a hidden way. \
Trying a joint switches its position if the joint is not locked; if it is locked, nothing happens. \
The goal is to move the target joint within the given steps. \
"""

CONSTANT = f"{_PROBLEM}Each reply says whether the last joint moved or did not move, then names the next joint to try."
"""The instruction, the same for every trial; it says nothing about which joint locks which."""

UNASKED = f"{_PROBLEM}Each reply names the next joint to try."
"""The instruction if the model is not asked what the last action did."""

_CONTEXT = 4096
"""The most tokens of a trial: about 130 steps."""

_CLAIMS = {f" {words}": outcome for words, outcome in CLAIMS.items() if outcome}


class LocalModel:
    """A model in a GGUF file that plays by scoring its possible replies.

    Args:
        engine: The loaded model.
        facts: The facts of the model, for the record.
        temperature: Above 0; probabilities are raised to 1/temperature and normalised, so 1 leaves the model's own.
    """

    def __init__(self, engine: Engine, facts: Mapping[str, Fact], temperature: float = 1.0) -> None:
        self._engine, self._temperature = engine, temperature
        words = [*_segments(example()), *_segments(example(assessment=False))]
        said: dict[str, Fact] = {
            "prompt": f"log {fingerprint(*words)}",
            "decoding": "scored answers",
            "temperature": temperature,
        }
        self.facts: Mapping[str, Fact] = {**facts, **said}

    @classmethod
    def from_spec(cls, spec: Spec) -> LocalModel:
        """Load the model that a spec names.

        Raises:
            UserMistake: As :func:`check`.
        """
        from lockprobe.agents.engine import Engine

        path = weights.locate(spec.full_name)
        engine = Engine(path, context=_CONTEXT)
        facts = {"model": weights.model_name(path), "sha256": weights.sha256_of(path)} | engine.facts()
        return cls(engine, facts, temperature_in(spec))

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Say what the last action did, then choose; two draws from the stream per step."""
        refuse_pictures(situation.percept, "a local model")
        if situation.briefing.instruction:
            raise Conflict("prompt", "a local model", "local models play from a log without an instruction")
        task = situation.task
        constant, *rest = _segments(situation)
        if not situation.past:
            self._engine.restart(constant)
        prompt = [*self._engine.opening(constant), *self._tokens(*rest)]
        if len(prompt) > _CONTEXT - 64:
            raise BadValue("max_steps", task.budget, f"a trial that fits this model's {_CONTEXT} tokens")
        claim = None
        if situation.percept.joint is not None and task.assessment:
            claim = self._engine.score(prompt, [self._engine.tokens(one) for one in _CLAIMS])[0]

        def chances(said: str) -> list[float]:
            asked = [*prompt, *self._tokens(said, "." if said else "", " Next joint:")]
            scaled = np.array(self._engine.score(asked, [self._engine.tokens(f" {joint}") for joint in task.joints]))
            if self._temperature != 1:
                scaled = (scaled / scaled.max()) ** (1 / self._temperature)  # one is 1, however low it is
            return (scaled / scaled.sum()).tolist()  # type: ignore[no-any-return]

        return drawn(situation, claim, chances, rng)

    def _tokens(self, *segments: str) -> list[int]:
        """Segments are turned into tokens one by one, so that equal segments give equal tokens everywhere."""
        return [token for segment in segments if segment for token in self._engine.tokens(segment)]


def temperature_in(spec: Spec) -> float:
    """The only option of a local model.

    Raises:
        UnknownName: If the spec has another one.
        BadValue: If the temperature is not above 0.
    """
    given = arguments_from(LocalModel, "a local model", spec.options, taken=("engine", "facts"))
    temperature = float(given.get("temperature", 1.0))  # type: ignore[arg-type]
    if not 0 < temperature < inf:
        raise BadValue("temperature", temperature, "a number above 0")
    return temperature


def check(spec: Spec) -> None:
    """Check whether a local model can be loaded.

    Raises:
        UserMistake: If its runtime or its file is missing or damaged.
    """
    import lockprobe.agents.engine  # noqa: F401 - raises if the runtime is missing

    weights.locate(spec.full_name)


def drawn(
    situation: Situation,
    claim: float | None,
    chances: Callable[[str], Sequence[float]],
    rng: np.random.Generator,
) -> Decision:
    """The decision of a local model, by two draws from the stream.

    Args:
        situation: What it decides on.
        claim: The probability that it says that its last action moved the joint; None if it says nothing of it.
        chances: From what it said to the probability of each joint.
        rng: The stream.
    """
    number = float(rng.random())
    said = "" if claim is None else list(_CLAIMS)[int(number >= claim)]
    probabilities = tuple(chances(said))
    joint = situation.task.joints[draw(probabilities, rng.random())]
    about = f"Last joint: {situation.percept.joint}{said}. " if said else ""
    return Decision(
        joint=joint,
        claimed=_CLAIMS.get(said),
        probabilities=probabilities,
        claim_probability=claim,
        replies=(f"{about}Next joint: {joint}",),
    )


def _segments(situation: Situation) -> list[str]:
    """The log up to the point where the model has to say what its last action did, or to choose."""
    task = situation.task
    segments = [
        CONSTANT if task.assessment else UNASKED,
        f" The joints are: {', '.join(task.joints)}.",
        f" The target joint is: {task.target}.",
        f" The given steps are: {task.budget}.",
        f" {situation.briefing.warning}".rstrip(),
        "\n\nStep log:",
    ]
    for turn in situation.past:
        segments += _observation(turn.percept.text, turn.remark)
        said = next((words for words, outcome in _CLAIMS.items() if outcome == turn.decision.claimed), "")
        # an earlier reply in the same segments in which it was asked for
        segments += ["Last joint:", f" {turn.percept.joint}", said, "."] if said else []
        segments += [" Next joint:", f" {turn.decision.joint}", "."]
    segments += _observation(situation.percept.text, situation.briefing.remark)
    if situation.percept.joint is not None and task.assessment:
        segments += ["Last joint:", f" {situation.percept.joint}"]
    return segments


def _observation(report: str, remark: str) -> tuple[str, ...]:
    return ("\nObservation:", f" {report}".rstrip(), f" {remark}".rstrip(), "\n")
