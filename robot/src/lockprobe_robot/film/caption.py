"""Captions under a film's pictures: the attempt, truth and report, and the agent's claim."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lockprobe.trial.record import Trial

WIDTH = 640
"""Width of a film, pixels."""

HEIGHT = 90
_PAPER, _INK, _FALSE = (250, 248, 242), (30, 30, 30), (190, 30, 30)
_TEXT = 20
_LINE = 27


CaptionLine = tuple[str, bool]
"""A line of the caption, and whether it states something false, which is shown in red."""


def opening_lines(trial: Trial) -> tuple[CaptionLine, ...]:
    """The first caption: agent, box, condition, target and budget."""
    target = trial.labels[trial.joints.index(trial.target)]
    played = f"{trial.called or trial.agent} on {trial.box}, {trial.modality}, trial {trial.repetition}.{trial.trial}"
    return (played, False), (f"Target: {target} ({trial.target}); {trial.budget} steps", False)


def outcome_lines(trial: Trial, at: int) -> tuple[CaptionLine, ...]:
    """The caption of a step, from 0: attempt, truth, report (of pictures if false), verdict and force, next claim."""
    step = trial.steps[at]
    label = trial.labels[trial.joints.index(step.joint)]
    truth = _word(step.moved)
    verdict = step.sensed.get("verdict")
    force = step.sensed.get("peak_force")
    felt = f" at {force:.0f} N" if isinstance(force, int | float) else ""
    robot = f", robot says {verdict}{felt}" if verdict in ("moved", "blocked", "failed") else ""
    silent = step.told_moved is None or (step.pictures and not step.told_falsely)
    told = "" if silent else f", told {_word(bool(step.told_moved))}"
    later = trial.said[at]
    last = "solved" if step.moved and step.joint == trial.target else ""
    return (
        (f"Step {at + 1} of {trial.budget}: {label} ({step.joint})", False),
        (f"truth {truth}{told}{robot}", step.told_falsely or (bool(robot) and verdict != truth)),
        (f"the agent then says {later}" if later in ("moved", "blocked") else last, later not in (None, truth)),
    )


def captioned(picture: NDArray[np.uint8], lines: Sequence[CaptionLine], corner: str = "") -> NDArray[np.uint8]:
    """A picture, scaled to the width of a film, with a caption of at most three lines under it.

    ``corner`` is a short text at the right of the first line. Shape (even number, WIDTH, 3).
    """
    height = 2 * round(picture.shape[0] * WIDTH / picture.shape[1] / 2)
    image = Image.fromarray(picture)
    if image.size != (WIDTH, height):
        image = image.resize((WIDTH, height), Image.Resampling.LANCZOS)
    whole = Image.new("RGB", (WIDTH, height + HEIGHT), _PAPER)
    whole.paste(image)
    draw, font = ImageDraw.Draw(whole), ImageFont.load_default(_TEXT)
    for i, (line, alarming) in enumerate(lines):
        text = line
        while draw.textlength(text, font=font) > WIDTH - 50:
            text = f"{text[:-4]}..."
        draw.text((10, height + 5 + i * _LINE), text, _FALSE if alarming else _INK, font=font)
    draw.text((WIDTH - 10, height + 5), corner, _INK, font=font, anchor="ra")
    return np.asarray(whole)


def _word(moved: bool) -> str:
    return "moved" if moved else "blocked"
