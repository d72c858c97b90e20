"""The measures that installed packages add, for every agent under every condition."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.plugins import find_plugin, plugin_names
from lockprobe.report.rows import MEASURES, Fact, Row
from lockprobe.report.study_numbers import PlayedCell, StudyNumbers
from lockprobe.statistics.measures import find_measure, measured


def measure_rows(numbers: StudyNumbers) -> Iterator[Row]:
    """The mean of each of those measures with its 95 % interval; of one that breaks, why.

    Args:
        numbers: A study; no code of a package runs if the opened study holds what they measured.
    """
    if numbers.opened.measured is not None:
        yield from numbers.opened.measured
        return
    names = plugin_names("measure")
    described: dict[str, Fact] = {}
    for cell in numbers.cells if names else ():
        for name in names:
            described_as, row = _of_cell(cell, name)
            yield row
            if described_as:
                described[name] = described_as
    yield from described.values()


def _of_cell(cell: PlayedCell, name: str) -> tuple[Fact | None, Row]:
    """A description of the measure, if it works, and its row."""
    plugin = find_plugin("measure", name)
    source, quantity = plugin.package if plugin else name, f"{MEASURES}.{name}"
    try:
        (found,) = measured(cell.trials, [find_measure(name)])
    except UserMistake as error:
        return None, cell.estimate(quantity, n=0, unit="", note=str(error), source=source)
    numbers = {"n": found.n, "low": found.low, "high": found.high, "unit": "share" if found.kind == "share" else ""}
    row = cell.estimate(quantity, found.value, **numbers, source=source)
    return Fact(about=MEASURES, name=name, text=found.what, source=source), row
