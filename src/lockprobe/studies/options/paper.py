"""The paper's studies; each number cites its section of the paper."""

from __future__ import annotations

from dataclasses import dataclass

from lockprobe.boxes.box import LayoutKind
from lockprobe.boxes.families import DEFAULT_BOX
from lockprobe.studies.study import Study
from lockprobe.trial.record import STATES, STRUCTURED

MAX_STEPS = 20
"""Sec. 2.2: "a maximum budget of 20 steps"."""

BOX = DEFAULT_BOX
"""Sec. 2.1 describes the box; its interlock is not public, so this one is a reconstruction."""

REFERENCES = ("random", "round-robin", "human-inspired")
"""Played with a model by default. The paper has the last (Sec. 3.1); without the others a rate means little."""

PERSEVERANT = "cognitive:perseverant"
"""Ours: false reports raise its success, and why is known: it repeats the joint that has just moved, and so undoes the
move, unless it is told that nothing moved."""

FIRST = (PERSEVERANT, "human-inspired", "llm:local", "random")
"""Ours: what plays the flip study where no agent is named. The same false reports help the first and hurt the second;
an embedded language model shows that any agent can be in their place."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Extent:
    """How much of the flip study is played; strategies play ``strategy_trials``, if that is given."""

    p: tuple[float, ...]
    repetitions: int
    trials: int
    strategy_trials: int | None = None


FULL = Extent(p=(0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6), repetitions=3, trials=10)
"""Sec. 3.2: 0 % to 60 % in increments of 10 %, three repetitions of 10 trials, 210 trials in all."""

SHORT = Extent(p=(0.0, 0.2, 0.4, 0.6), repetitions=3, trials=2, strategy_trials=100)
"""Ours: what the embedded model plays in a minute on two cores, and enough trials of the others, which cost nothing, to
see what false reports do to them."""

SHORT_OF_MODELS = (0.0, 0.4)
"""Ours: the flip rates at which models play the short study beside strategies; six trials at more would say no more."""

EACH_BOX = Extent(p=SHORT.p, repetitions=1, trials=5, strategy_trials=20)
"""Ours: the trials on each of several boxes. With 10 boxes the first find the paper's effect in .9 of studies if it
differs between boxes by 30 points, and the second find that it differs."""

ONE_TRIAL = Extent(p=(0.0,), repetitions=1, trials=1)
"""Ours: the shortest study there is."""


MODALITIES = ("rgb", "rgbd", STATES)
"""Sec. 2.2: RGB images, RGB-D images, and the ground-truth symbolic state, from low to high fidelity."""

MODALITIES_AS_PAPER = ("rgb", "rgbd", STRUCTURED)
"""The same, and the symbolic state as Fig. 2 describes it: "a structured representation specifying the predefined
labels of each Lockbox joint and its corresponding state"."""

MODALITY_TRIALS = Extent(p=(0.0,), repetitions=1, trials=10)
"""Sec. 2.2: "10 independent trials per modality", without false reports."""

MODALITY_PANEL: LayoutKind = "shuffled"
"""Ours: in every trial the joints are dealt anew to the places of the panel. The paper has one panel, and its section
on limitations says so. Pictures show where joints sit, and words do not: if neighbours lock each other, pictures tell
more."""

LOOKERS = ("viewer", "human-inspired", "random")
"""Ours: what plays the modality study without a model. The paper's is GPT o1, with the human-inspired strategy."""

ROBOT = "fast-twin"
"""Ours: the paper has a real robot (Sec. 2.1); ``twin`` has its arm, and is slower."""


def is_short(study: Study) -> bool:
    """Whether a study has the short extent."""
    return study.of_flips and (study.p, study.repetitions, study.trials) == (SHORT.p, SHORT.repetitions, SHORT.trials)
