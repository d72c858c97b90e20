"""How money is written, wherever it is."""

from __future__ import annotations

from math import floor, log10

__all__ = ["dollars"]


def dollars(amount: float) -> str:
    """US dollars to the cent, less than ten cents to two digits; without their sign.

    >>> [dollars(amount) for amount in (1234.5, 0.0144, 0.000077)]
    ['1,234.50', '0.014', '0.000077']
    """
    if amount >= 0.1 or amount <= 0:
        return f"{amount:,.2f}"
    said = f"{amount:.{1 - floor(log10(amount))}f}"
    return said[:4] + said[4:].rstrip("0")
