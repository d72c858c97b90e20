"""What a participant does in a scene, as the page sends it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from lockprobe.people.scenes import LONGEST_ANSWER

__all__ = ["Act", "Agree", "Answer", "Attempt", "Next"]

Milliseconds = Annotated[float, Field(ge=0, le=1e9, allow_inf_nan=False)]
"""Of the page's monotonic clock (``performance.now``); what is measured from is said where it stands."""

Pixels = Annotated[int, Field(ge=0, le=100_000)]

Label = Annotated[str, Field(min_length=1, max_length=8)]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Agree(_Part):
    """Of ``Consent``: yes or no."""

    kind: Literal["agree"] = "agree"
    agreed: bool
    code: Annotated[str, Field(max_length=100)] = ""


class Next(_Part):
    """Of ``Page`` and ``TrialOver``: go on."""

    kind: Literal["next"] = "next"


class Attempt(_Part):
    """Of ``Box``: a joint is chosen.

    Attributes:
        joint: Its label.
        claimed: What is said of the last action, where it was asked.
        rt: From when the scene was painted to the choice of the joint, ms; without the time for ``claimed``.
        claimed_rt: From when the scene was painted to what was said of the last action, ms; None where not asked.
        pointer: With what the joint was chosen; None where that is not kept.
        viewport: Width and height of the window, CSS pixels; None where that is not kept.
    """

    kind: Literal["attempt"] = "attempt"
    joint: Label
    claimed: Literal["moved", "blocked"] | None = None
    rt: Milliseconds
    claimed_rt: Milliseconds | None = None
    pointer: Literal["mouse", "touch", "pen", "keyboard"] | None = None
    viewport: tuple[Pixels, Pixels] | None = None


class Answer(_Part):
    """Of ``Check`` and ``Ask``: an option by its words, or words.

    Attributes:
        answer: The answer; empty where an ``Ask`` that is not required is passed over.
        rt: From when the scene was painted to the answer, ms.
    """

    kind: Literal["answer"] = "answer"
    answer: Annotated[str, Field(max_length=LONGEST_ANSWER)]
    rt: Milliseconds


Act = Annotated[Agree | Next | Attempt | Answer, Field(discriminator="kind")]
"""What a participant does in a scene."""
