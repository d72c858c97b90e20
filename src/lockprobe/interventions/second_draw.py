"""A second random number for each joint from the one that a report draws, so that no further number is drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, overload

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_ALL = (1 << 64) - 1
_GAMMA, _ONE, _TWO = 0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB


@overload
def survival(drawn: float, place: int) -> float: ...
@overload
def survival(drawn: NDArray[np.float64], place: int) -> NDArray[np.float64]: ...
def survival(drawn: Any, place: int) -> Any:
    """The number in [0, 1) that decides at a report whether a false position survives it: it does below ``keep``.

    It is the output with the number of the place of the generator SplitMix64 (Steele, Lea and Flood 2014), begun at
    the bits of the drawn number. Equal draws and places give equal numbers, so that survivals are nested in ``keep``.

    Args:
        drawn: The number drawn for the report, or an array of them: multiples of 2**-53 in [0, 1).
        place: The place of the joint in the listing, from 0.
    """
    scaled = drawn * 2.0**53
    bits: Any = int(scaled) if isinstance(scaled, float) else scaled.astype("uint64")
    bits = bits + ((place + 1) * _GAMMA & _ALL) & _ALL  # arrays overflow by themselves
    bits = (bits ^ (bits >> 30)) * _ONE & _ALL
    bits = (bits ^ (bits >> 27)) * _TWO & _ALL
    return ((bits ^ (bits >> 31)) >> 11) * 2.0**-53
