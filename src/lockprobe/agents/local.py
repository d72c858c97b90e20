"""Local language models: the embedded model, and any GGUF file.

They play from a growing log of everything they are told, worded as in the record. They do not generate text: where a
reply leaves a choice, the allowed answers are scored exactly and one is drawn from the random stream of the trial. So
replies are always well formed, the probability of every joint is known, and the same seed gives the same trial on one
machine. Figures stand in ``docs/models.md``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from lockprobe.agents import weights
from lockprobe.agents.policy import draw, refuse_pictures
from lockprobe.agents.prompt import example, fingerprint
from lockprobe.agents.reply import CLAIMS
from lockprobe.foundation.errors import BadValue, Conflict, ModelFault
from lockprobe.foundation.spec import Spec, with_options
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


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalSettings:
    """The options of a local model: ``llm:local?temperature=0.7``.

    Attributes:
        temperature: Above 0; probabilities are raised to 1/temperature and normalised, so 1 leaves the model's own.

    Raises:
        BadValue: If the temperature is not above 0.
    """

    temperature: float = 1.0

    def __post_init__(self) -> None:
        if not 0 < self.temperature < inf:
            raise BadValue("temperature", self.temperature, "a number above 0")

    @classmethod
    def parse(cls, spec: Spec) -> LocalSettings:
        """The options of a spec."""
        return with_options(cls, "a local model", spec.options)


def check(spec: Spec) -> None:
    """Check whether a local model can be loaded.

    Raises:
        UserMistake: If its runtime or its file is missing or damaged.
    """
    import lockprobe.agents.engine  # noqa: F401 - raises if the runtime is missing

    weights.locate(spec.full_name)


class LocalModel:
    """A model in a GGUF file that plays by scoring its possible replies.

    Args:
        engine: The loaded model.
        facts: The facts of the model, for the record.
        settings: Its options.
    """

    def __init__(self, engine: Engine, facts: Mapping[str, Fact], settings: LocalSettings | None = None) -> None:
        self._engine, self._settings = engine, settings or LocalSettings()
        self.facts: Mapping[str, Fact] = {
            **facts,
            "prompt": f"log {fingerprint(*_segments(example()))}",
            "prompt_unasked": f"log {fingerprint(*_segments(example(assessment=False)))}",
            "decoding": "scored answers",
            **asdict(self._settings),
        }

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
        return cls(engine, facts, LocalSettings.parse(spec))

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Say what the last action did, then choose; two draws from the stream per step."""
        refuse_pictures(situation.percept, "a local model")
        if situation.briefing.instruction:
            raise Conflict("prompt", "a local model", "local models play from a log without an instruction")
        task, last = situation.task, situation.percept.joint
        constant, *rest = _segments(situation)
        if not situation.past:
            self._engine.restart(constant)
        prompt = [*self._engine.opening(constant), *self._tokens(*rest)]
        if len(prompt) > _CONTEXT - 64:
            raise BadValue("max_steps", task.budget, f"a trial that fits this model's {_CONTEXT} tokens")
        said, claim_probability, number = "", None, float(rng.random())
        if last is not None and task.assessment:
            chances = self._engine.score(prompt, [self._engine.tokens(claim) for claim in _CLAIMS])
            claim_probability = chances[0]
            said = _said(number, claim_probability)
            prompt += self._tokens(said, ".")
        prompt += self._tokens(" Next joint:")
        raw = self._engine.score(prompt, [self._engine.tokens(f" {joint}") for joint in task.joints])
        scaled = np.array(raw)
        if self._settings.temperature != 1:
            scaled = (scaled / scaled.max()) ** (1 / self._settings.temperature)  # one is 1, however low it is
        return _drawn(situation, said, claim_probability, (scaled / scaled.sum()).tolist(), rng)

    def _tokens(self, *segments: str) -> list[int]:
        """Segments are turned into tokens one by one, so that equal segments give equal tokens everywhere."""
        return [token for segment in segments if segment for token in self._engine.tokens(segment)]


class ReplayedLocalModel:
    """A local model in a trial that has ended: it draws again from the probabilities on record, and scores nothing.

    Args:
        facts: The facts of the model, from the record.
        decisions: Its decisions on record.
    """

    def __init__(self, facts: Mapping[str, Fact], decisions: Iterable[Decision]) -> None:
        self.facts, self._decisions = facts, iter(decisions)

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Draw a claim and a joint; two draws from the stream per step.

        Raises:
            ModelFault: If the record ends here, or has no probabilities.
        """
        recorded = next(self._decisions, None)
        if recorded is None or recorded.probabilities is None:
            raise ModelFault("the record ends here")
        said, number = "", float(rng.random())
        if recorded.claim_probability is not None:
            said = _said(number, recorded.claim_probability)
        return _drawn(situation, said, recorded.claim_probability, recorded.probabilities, rng)


def _said(number: float, probability: float) -> str:
    """The claim that a random number gives; ``probability`` is that of the first."""
    return list(_CLAIMS)[int(number >= probability)]


def _drawn(
    situation: Situation, said: str, probability: float | None, chances: Sequence[float], rng: np.random.Generator
) -> Decision:
    """The decision of a model that has said this about its last action, with its next joint drawn."""
    joint, last = situation.task.joints[draw(chances, rng.random())], situation.percept.joint
    reply = f"Last joint: {last}{said}. Next joint: {joint}" if said else f"Next joint: {joint}"
    return Decision(
        joint=joint,
        claimed=_CLAIMS.get(said),
        probabilities=tuple(chances),
        claim_probability=probability,
        replies=(reply,),
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
