"""The words for modalities, and their order by fidelity: RGB, RGB-D, ground truth (paper, Sec. 3.1)."""

from __future__ import annotations

from collections.abc import Mapping

from lockprobe.foundation.spec import Spec

_SPOKEN: Mapping[str, str] = {"rgb": "RGB", "rgbd": "RGB-D", "symbolic": ""}
"""The paper's modalities from low to high fidelity; its ground truth is true positions in words."""

_CONTENTS: Mapping[str, str] = {"both": "positions and outcomes", "state": "positions", "outcome": "outcomes"}
"""What a report in words tells."""

_FORMS: Mapping[str, str] = {"words": "in words", "json": "as JSON"}
"""The form of a report in words."""

_SOURCES: Mapping[str | None, str] = {"verdict": "verdicts of the arm", "camera": "readings of the camera"}
"""Sources of reports in words that are not the truth; the paper has none of them."""


def spoken(modality: str) -> str:
    """A modality in plain words, with its options. What the paper calls ground truth can be false here.

    >>> spoken("rgbd?blur=8"), spoken("symbolic?tell=state"), spoken("symbolic?form=json")
    ('RGB-D, blur=8', 'positions in words', 'positions and outcomes as JSON')
    """
    spec = Spec.parse(modality, "modality")
    called = _SPOKEN.get(spec.full_name, spec.full_name)
    if (source := spec.options.get("source")) in _SOURCES:
        return ", ".join((_SOURCES[source], *_said(spec.without(["source"]))))
    if spec.full_name == "symbolic":
        content, form = (spec.options.get(one, default) for one, default in (("tell", "both"), ("form", "words")))
        called, spec = f"{_CONTENTS[content]} {_FORMS[form]}", spec.without(["tell", "form"])
    return ", ".join((called, *_said(spec)))


def _said(spec: Spec) -> list[str]:
    return [f"{option}={value}" for option, value in spec.options.items()]


def by_fidelity(modality: str) -> tuple[int, str]:
    """The sort key of a modality, from low to high fidelity."""
    rank = fidelity(modality)
    return len(_SPOKEN) if rank is None else rank, modality


def fidelity(modality: str) -> int | None:
    """The rank of a modality's fidelity from 0, equal for all its variants; None if the paper does not rank it."""
    spec = Spec.parse(modality, "modality")
    ranked = spec.full_name in _SPOKEN and spec.options.get("source") not in _SOURCES
    return list(_SPOKEN).index(spec.full_name) if ranked else None
