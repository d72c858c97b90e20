"""Formats for readers: per cent, points, P values, intervals, minus signs, counts, lists, and the time of day."""

from __future__ import annotations

import math
import os
import re
import time
from collections.abc import Iterable, Sequence

NONE = "\N{EN DASH}"
"""A cell without a value."""

MOST_NAMED = 3
"""Agents whose numbers stand in a sentence; of more it has the range over all of them."""

epoch_held = ""
"""SOURCE_DATE_EPOCH, where a command took it out of the environment: scipy and PDF files would read it, too."""

_LEVEL = 0.05
"""Below it a difference is detected."""

_LEAST = 1e-3
"""An end nearer to 0 is taken for it."""


def percent(value: float | None, digits: int = 0) -> str:
    """A share in per cent, or a dash where there is none.

    >>> percent(0.125), percent(0.125, 1)
    ('12 %', '12.5 %')
    """
    return NONE if value is None or math.isnan(value) else f"{100 * value:.{digits}f} %"


def points(value: float) -> str:
    """A difference of shares in percentage points, with its sign; what rounds to 0 has none.

    >>> points(0.26), points(-0.004)
    ('+26', '0')
    """
    return minus(f"{100 * value:+.0f}")


def end_of(value: float, form: str = "{:+.0f}", scale: float = 100) -> str:
    """An end of an interval of a difference, in points if nothing else is said: only 0 looks like 0.

    >>> end_of(-0.164), end_of(-0.0041), end_of(0)
    ('\N{MINUS SIGN}16', '\N{MINUS SIGN}0.4', '0')
    """
    said = form.format(scale * value)
    hidden = "+" in form and float(said) == 0 and abs(scale * value) > _LEAST
    return minus(f"{scale * value:+.1g}" if hidden else said)


def p_value(value: float | None) -> str:
    """A P value; the capital letter tells it from a flip rate.

    >>> p_value(0.0004), p_value(0.84), p_value(None)
    ('P < 0.001', 'P = 0.84', 'not tested')
    """
    if value is None:
        return "not tested"
    return "P < 0.001" if value < 0.001 else f"P = {p_cell(value)}"


def p_cell(value: float | None) -> str:
    """A P value in a cell: two digits, or more where two would move it to 0.05 from below; a dash without one.

    >>> p_cell(0.0494), p_cell(0.0496), p_cell(0.0504)
    ('0.049', '0.0496', '0.05')
    """
    if value is None or math.isnan(value):
        return NONE
    digits = next(n for n in range(2, 18) if value >= _LEVEL or float(f"{value:.{n}g}") < _LEVEL)
    return f"{value:.{digits}g}"


def minus(text: str) -> str:
    """The text with minus signs for hyphens, except between letters; a number that is rounded to 0 has no sign.

    >>> minus("+0 [-0.0, +0.04], at most +0.")
    '0 [0.0, +0.04], at most 0.'
    """
    text = re.sub(r"(?<!\w)[+-](?=0(?:\.0+)?(?!\w|\.\w))", "", text)
    return re.sub(r"(?<![A-Za-z])-|-(?![A-Za-z])", "\N{MINUS SIGN}", text)


def bracketed(
    value: float | None, low: float | None, high: float | None, form: str = "{:+.0f}", scale: float = 100
) -> str:
    """A value with its interval in a cell, in points if nothing else is said; a dash where there is none.

    >>> bracketed(0.1, 0.02, 0.18), bracketed(1.5, None, None, "{:.2f}", 1)
    ('+10 [+2, +18]', '1.50')
    """
    if value is None or math.isnan(value):
        return NONE
    said = minus(form.format(scale * value))
    if low is not None and high is not None:
        said += f" [{end_of(low, form, scale)}, {end_of(high, form, scale)}]"
    return said


def range_of(low: float, high: float) -> str:
    """Two shares and what lies between them.

    >>> range_of(0.54, 0.67)
    '54 to 67 %'
    """
    return f"{100 * low:.0f} to {percent(high)}"


def first_three(parts: Iterable[str], between: str = ", ") -> str:
    """The first three of a list, and how many more there are.

    >>> first_three("abc"), first_three("abcde")
    ('a, b, c', 'a, b, c and 2 more')
    """
    first, more = (every := [*parts])[:3], len(every) - 3
    return between.join(first) + (f" and {more} more" if more > 0 else "")


def count(number: int, one: str, several: str | None = None) -> str:
    """A number of things, in words.

    >>> count(1, "trial"), count(2, "trial"), count(3, "reply", "replies")
    ('1 trial', '2 trials', '3 replies')
    """
    return f"{number} {one if number == 1 else several or f'{one}s'}"


def listed(names: Sequence[str], last: str = "and", named: int | None = None) -> str:
    """All names; with ``named`` at most so many, the others as a number.

    >>> listed(["a", "b"], "or"), listed(["a", "b", "c"]), listed(["a", "b", "c", "d"], named=3)
    ('a or b', 'a, b and c', 'a, b and 2 others')
    """
    if named is not None and len(names) > named:
        names = [*names[: named - 1], f"{len(names) - named + 1} others"]
    *most, end = names
    return f"{', '.join(most)} {last} {end}" if most else end


def capital(said: str) -> str:
    """The text at the beginning of a sentence."""
    return f"{said[:1].upper()}{said[1:]}"


def time_said() -> str:
    """The time now, ``14:02 on 29 November 2026``; or SOURCE_DATE_EPOCH, by which equal records give equal files."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", epoch_held)
    at = time.gmtime(int(epoch)) if epoch.isdecimal() and len(epoch) < 12 else time.localtime()
    return f"{time.strftime('%H:%M on', at)} {at.tm_mday} {time.strftime('%B %Y', at)}"
