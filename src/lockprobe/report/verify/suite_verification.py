"""Verification of a suite: each of its studies, whether they are the studies of the suite, and the scores."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from lockprobe.foundation.errors import LockprobeError
from lockprobe.report.suite.page import PAGE, suite_page
from lockprobe.report.suite.results import suite_results
from lockprobe.report.verify.check import Check, check_of
from lockprobe.report.verify.checked_report import check_file, check_page
from lockprobe.report.verify.verification import hash_check, verify
from lockprobe.studies.file_names import SCORES
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.records.results_hash import hashes_of_suite
from lockprobe.studies.suites import Suite, read_suite, suite_directories, suite_study

__all__ = ["verify_suite"]


def verify_suite(
    directory: Path,
    *,
    settings: str | None = None,
    results: str | None = None,
    processes: int = 1,
    tell: Callable[[int, int], None] = lambda done, of: None,
) -> tuple[Check, ...]:
    """Recompute a suite from its records, and hold its directory against that.

    Args:
        directory: The directory of a suite.
        settings: The hash of its settings, as it was published; None checks none.
        results: The hash of its records likewise.
        processes: Processes that may work at a large report.
        tell: Called with the number of trials of a study played again, and of all of it.

    Returns:
        The checks in order, those of a study with its name before them.
    """
    try:
        suite = read_suite(directory)
    except LockprobeError as error:
        return (Check(name="suite", holds=False, said=str(error)),)
    names = suite_directories(directory, suite)
    studies = (
        replace(check, name=f"{name}: {check.name}")
        for name in names
        for check in verify(directory / name, processes=processes, tell=tell)
    )
    wrong = list(_unlike(directory, suite, names))
    definition = check_of("suite", wrong, f"the studies are those of {suite.name}", "faults in the studies")
    return (definition, *_of_hashes(directory, suite, settings, results), *studies, *_scores(directory))


def _of_hashes(directory: Path, suite: Suite, settings: str | None, results: str | None) -> Iterator[Check]:
    """Whether settings and records are those of the published hashes."""
    if settings is None and results is None:
        return
    try:
        found = hashes_of_suite(directory, suite)
    except LockprobeError as error:
        yield Check(name="hashes", holds=False, said=str(error))
        return
    if settings is not None:
        yield hash_check("settings", settings, found.settings)
    if results is not None:
        yield hash_check("results", results, found.results)


def _scores(directory: Path) -> Iterator[Check]:
    """Whether ``suite.json`` and the page are what the records give."""
    try:
        found, page = suite_page(suite_results(directory))
    except LockprobeError as error:
        yield Check(name="scores", holds=False, said=str(error))
        return
    yield check_file("scores", directory / SCORES, found.plain())
    if (directory / PAGE).exists():
        yield check_page("page", directory / PAGE, page)


def _unlike(directory: Path, suite: Suite, names: list[str]) -> Iterator[str]:
    """Studies that are not those of the suite, or have other agents than those of other levels."""
    if not names:
        yield "there is no study"
    agents: dict[str, set[str]] = {}
    for name in names:
        try:
            found = read_study(directory / name)
        except LockprobeError as error:
            yield str(error)
            continue
        if found.settings() != suite_study(suite, name, found.agents, found.names).settings():
            yield f"{name}: its settings are not those of {suite.name}"
        ending = next(name.removeprefix(box) for box in suite.boxes if name.startswith(box))
        agents.setdefault(ending, set()).add(" ".join(found.labels))
    for ending, players in agents.items():
        for box in suite.boxes:
            if f"{box}{ending}" not in names:
                yield f"{box}{ending}: there is no such study"
        if len(players) > 1:
            yield f"the levels{ending} have different agents: {'; '.join(sorted(players))}"
