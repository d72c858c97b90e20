"""What agents saw: pictures of one trial of each modality."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from itertools import count, takewhile
from pathlib import Path

from lockprobe.foundation.errors import BadFile, BadValue, Missing
from lockprobe.foundation.inputs import read_input
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.rows import Fact, Results
from lockprobe.report.section import Part, Section, Template
from lockprobe.studies.records.store import ALBUM
from lockprobe.trial.pictures.frame import from_png, to_png
from lockprobe.trial.pictures.picture import PICTURE_NAME, PictureKind
from lockprobe.trial.record import Trial, in_words

_ABOUT = "seen "
"""What facts are about: this and the modality, with the number of a moment for what was seen then."""

_KINDS: tuple[PictureKind, ...] = ("rgb", "depth")
"""Kinds that agents are shown; the others are kept for the record."""

_WIDE = 320
"""Pixels across a picture on a page, at most."""


def _rows(numbers: OpenedStudy) -> Iterator[Fact]:
    """Of each modality the first trial that was played for a step: before it, after it, and after the first move."""
    first: dict[str, Trial] = {}
    for trial in numbers.trials:
        if trial.opening_pictures and trial.steps:
            first.setdefault(trial.modality, trial)
    for modality, trial in first.items():
        yield Fact(about=f"{_ABOUT}{modality}", name="trial", text=trial.key)
        first_move = next((step for step in trial.steps if step.moved), trial.steps[0])
        moments = [("before the first step", trial.opening, trial.opening_pictures)]
        for step in trial.steps[:1] + (first_move,) * (first_move.step > 1):
            when = f"after step {step.step}: {step.joint} {in_words(step.moved)}"
            moments.append((when, step.told, step.pictures))
        shown = [(when, told, files) for when, told, files in moments if any(kind in files for kind in _KINDS)]
        for number, (when, told, files) in enumerate(shown, 1):
            facts = {"when": when, "told": told} | {kind: files[kind] for kind in _KINDS if kind in files}
            for name, text in facts.items():
                yield Fact(about=f"{_ABOUT}{modality} {number}", name=name, text=text)


def embedded(directory: Path, found: Results) -> dict[str, str]:
    """The pictures that the page shows as data, made small.

    Those that are not there or damaged are left out, and all where the package that reads pictures is missing.
    """
    small = {
        fact.text: _small(directory, fact.text, kind)
        for fact in found.facts
        for kind in _KINDS
        if fact.about.startswith(_ABOUT) and fact.name == kind and PICTURE_NAME.fullmatch(fact.text)
    }
    return {name: f"data:image/png;base64,{base64.b64encode(png).decode()}" for name, png in small.items() if png}


def _small(directory: Path, name: str, kind: PictureKind) -> bytes | None:
    """Of colours, the mean of every block; of depth, one pixel of it: the mean of two codes is the code of neither."""
    try:
        pixels = from_png(read_input(directory / ALBUM / name))
    except (BadFile, BadValue, Missing):
        return None
    step = -(-pixels.shape[1] // _WIDE)
    if kind == "depth":
        return to_png(pixels[step // 2 :: step, step // 2 :: step])
    high, wide = (side // step * step for side in pixels.shape[:2])
    blocks = pixels[:high, :wide].reshape(high // step, step, wide // step, step, -1).mean(axis=(1, 3))
    return to_png(blocks.round().astype(pixels.dtype).squeeze())


def _show(found: Results) -> Iterator[Part]:
    shown: list[dict[str, object]] = []
    for fact in found.facts:
        if fact.about.startswith(_ABOUT) and fact.name == "trial":
            moments = [*takewhile(bool, (found.facts_about(f"{fact.about} {number}") for number in count(1)))]
            shown.append({"modality": fact.about.removeprefix(_ABOUT), "key": fact.text, "moments": moments})
    if shown:
        yield Part("What agents saw", "Pictures from one trial of each modality.", [Template("seen", {"shown": shown})])


SECTIONS = (Section("seen", "What agents saw", _rows, _show),)
