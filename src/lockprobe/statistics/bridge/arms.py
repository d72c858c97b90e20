"""The arms of the bridge from pictures to flips, which a study plays and its analysis finds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lockprobe.foundation.spec import Spec
from lockprobe.statistics.conditions.series import SeriesArm

__all__ = ["ARMS", "PICTURES", "WORDS", "bridges_of"]

WORDS, PICTURES = "words", "pictures"
"""The arms that differ: true reports in words, and pictures."""

ARMS: Mapping[str, str] = {
    "replayed": "yoked?claims={source}",
    "shuffled": "yoked?claims={source}&how=shuffle",
    "profile": "flip?like={source}",
    "symmetric": "flip?like={source}&by=total",
}
"""Arm -> its intervention in words: the misreadings of the pictures one by one; as many at random steps; flips at the
rates of hidden and of invented moves of every joint; flips at the total rate of misreadings. The first is the question,
the others take away its time, its sequence and its kind."""

_READING = ("inverts", "keep", "others")
"""The options that say what a false report is; the same in all arms."""


def bridges_of(conditions: Sequence[SeriesArm]) -> list[dict[str, str]]:
    """The bridges of a study: each a condition in pictures and those that repeat its misreadings in words.

    Returns:
        For each bridge the label of the condition of every arm; :data:`WORDS`, :data:`PICTURES` and ``replayed`` are
        always among them.
    """
    found: dict[tuple[str, str, str], dict[str, str]] = {}
    pictured = {one.label: one for one in conditions}
    words = {one.modality: one.label for one in reversed(conditions) if not one.acting}
    for one in conditions:
        if len(one.specs) == 1 and (named := _arm_of(one.specs[0])) is not None:
            arm, source, reading = named
            if source in pictured and one.modality in words and pictured[source].modality != one.modality:
                own = found.setdefault((source, one.modality, reading), {})
                own |= {WORDS: words[one.modality], PICTURES: source, arm: one.label}
    return [own for own in found.values() if "replayed" in own]


def _arm_of(spec: Spec) -> tuple[str, str, str] | None:
    """The arm of an intervention, its source and its reading; None if it is of no arm."""
    source = spec.options.get("claims" if spec.full_name == "yoked" else "like")
    if source is None or float(spec.options.get("p", 1)) != 1:
        return None
    bare = spec.without([*_READING, "p"])
    reading = "&".join(f"{name}={spec.options[name]}" for name in _READING if name in spec.options)
    for arm, text in ARMS.items():
        wanted = Spec.parse(text)
        options = {name: value.format(source=source) for name, value in wanted.options.items()}
        if (bare.full_name, dict(bare.options)) == (wanted.full_name, options):
            return arm, source, reading
    return None
