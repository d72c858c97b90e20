"""The doses of a condition: how much each of its interventions does, by name, as a record holds them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

from lockprobe.foundation.spec import Spec

MODALITY_DOSES: tuple[str, ...] = ("blur", "noise", "occlude", "exposure")
"""Options of a modality that are doses: how much pictures are degraded."""


def dose_of(spec: Spec, option: str, first: str) -> float:
    """A dose of an intervention; that of ``keep`` may be said in a word.

    >>> flip = Spec.parse("flip?p=0.4&others=kept")
    >>> dose_of(flip, "p", "p"), dose_of(flip, "keep", "p"), dose_of(Spec.parse("flip?p=0.4"), "keep", "p")
    (0.4, 1.0, 0.0)

    Every spec says its ``first`` dose, which is NaN otherwise. Another one is 0 if it is left out.
    """
    unsaid = "nan" if option == first else "0"
    if (spec.full_name, option, spec.options.get("others")) == ("flip", "keep", "kept"):
        unsaid = "1"
    return float(spec.options.get(option, unsaid))


def without_doses(spec: Spec, options: Sequence[str]) -> Spec:
    """The spec without these doses, however they are said.

    >>> str(without_doses(Spec.parse("flip?p=0.4&others=kept"), ["keep"]))
    'flip?p=0.4'
    """
    return spec.without([*options, *(["others"] if spec.full_name == "flip" and "keep" in options else [])])


def flip_rate(specs: tuple[str, ...], modality: str, doses: Mapping[str, float]) -> float | None:
    """The flip rate (paper, Sec. 3.2), [0, 1], if one plain flip acts alone, 0 under the truth; else None.

    Reports from a source that can be wrong (:mod:`lockprobe.trial.source`) are not the truth.
    """
    return doses.get("flip.p", 0.0) if _flips_alone(specs, modality) else None


@lru_cache(maxsize=4096)
def _flips_alone(specs: tuple[str, ...], modality: str) -> bool:
    found = [Spec.parse(spec, "intervention") for spec in specs]
    plain = {"p", "inverts", "others", "keep"}  # the options of a flip that acts on every report
    flips = [one for one in found if one.full_name == "flip" and one.options.keys() <= plain]
    true = Spec.parse(modality, "modality").options.get("source", "truth") == "truth"
    return true and len(specs) <= 1 and len(flips) == len(specs) and not modality_doses(modality)[1]


@lru_cache(maxsize=1024)
def modality_doses(modality: str) -> tuple[str, Mapping[str, str]]:
    """A modality without its doses, and the doses.

    >>> modality_doses("rgbd?blur=8")
    ('rgbd', {'blur': '8'})
    """
    spec = Spec.parse(modality, "modality")
    doses = {option: value for option, value in spec.options.items() if option in MODALITY_DOSES}
    return str(spec.without(doses)), doses
