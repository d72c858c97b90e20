"""Time and memory of every command on studies of 1 000 to 1 000 000 trials of strategies.

    uv run python benchmarks/million_trials.py [--sizes 1000,10000,100000] [--out DIR] [--commands run,status,...]

Five strategies play at four flip rates. Every command runs in a process of its own. Its CPU time is that of it and its
children; its memory is the largest sum of the resident sets of all of them, looked at twenty times a second, so what
two processes share counts twice. ``resume`` goes on after the run was killed (``kill -9``) with half of the records on
disk. ``compare`` has a second study, of other luck and at most 10 000 trials. One million takes an hour.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import results_hash, stored_records
from lockprobe.studies.records.store import read

AGENTS = ("random", "random-no-repeat", "round-robin", "human-inspired", "cognitive:perseverant")
RATES = (0, 0.1, 0.2, 0.4)
COMMANDS = ("run", "resume", "status", "report", "verify", "export", "records", "import", "compare")


@dataclass(frozen=True)
class Cost:
    """What a command cost: seconds, seconds of all processors, and MB at most."""

    wall: float
    processor: float
    memory: float


def lockprobe(*words: str | Path) -> list[str]:
    """A command of Lockprobe."""
    return [sys.executable, "-m", "lockprobe", *map(str, words)]


def play(directory: Path, trials: int, seed: int = 1) -> list[str]:
    """The command that plays so many trials in all."""
    each = max(1, trials // (len(AGENTS) * len(RATES)))
    agents = [word for agent in AGENTS for word in ("--agent", agent)]
    sizes = ("--p", ",".join(map(str, RATES)), "--trials", str(each), "--repetitions", "1", "--seed", str(seed))
    return lockprobe("run", "flips", *agents, *sizes, "--out", directory, "--no-report")


def family(pid: int) -> Iterator[int]:
    """A process and all that it started."""
    yield pid
    try:
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="utf-8").split()
    except OSError:
        return
    for child in children:
        yield from family(int(child))


def resident(pid: int) -> float:
    """The resident set of a process, MB; 0 if it has ended."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text(encoding="utf-8").split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
    except (OSError, IndexError):
        return 0.0


def cost(command: list[str]) -> Cost:
    """Run a command to its end.

    Raises:
        RuntimeError: If it fails.
    """
    began, most = time.perf_counter(), 0.0
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=said)
        while not (done := os.wait4(process.pid, os.WNOHANG))[0]:
            most = max(most, sum(map(resident, family(process.pid))))
            time.sleep(0.05)
        wall = time.perf_counter() - began
        process.returncode = os.waitstatus_to_exitcode(done[1])
        if process.returncode:
            said.seek(0)
            raise RuntimeError(f"{' '.join(command)}: {said.read()[-500:].decode()}")
    return Cost(wall, done[2].ru_utime + done[2].ru_stime, max(most, done[2].ru_maxrss / 1e3))


def killed_halfway(command: list[str], store: Path, trials: int) -> None:
    """Start a run and kill it, and all that it started, when so many records are on disk."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    found = 0
    while found < trials and process.poll() is None:
        time.sleep(0.05)
        if store.exists():
            with closing(sqlite3.connect(f"file:{store}?mode=ro", uri=True)) as db:
                found = db.execute("select coalesce(max(id), 0) from trial").fetchone()[0]
    process.send_signal(signal.SIGKILL)
    process.wait()


def results(directory: Path) -> str:
    """The hash of the results of a study."""
    with read(directory) as store:
        return results_hash(read_study(directory), stored_records(store))


def costs(directory: Path, trials: int, commands: list[str]) -> Iterator[tuple[str, Cost]]:
    """Each command with its cost on a study of so many trials."""
    study, other, copy = directory / f"study-{trials}", directory / "other", directory / "copy"
    if "run" in commands or not study.exists():
        shutil.rmtree(study, ignore_errors=True)
        yield "run", cost(play(study, trials))
    if "resume" in commands:
        shutil.rmtree(copy, ignore_errors=True)
        killed_halfway(play(copy, trials), copy / "study.db", trials // 2)
        yield "resume", cost(play(copy, trials))
        print(f"resumed records are {'the same' if results(copy) == results(study) else 'OTHERS'}", file=sys.stderr)
    if "compare" in commands and not other.exists():
        cost(play(other, min(trials, 10_000), seed=2))
    for name, words in (
        ("status", ("status", study)),
        ("report", ("report", study)),
        ("verify", ("verify", study)),
        ("export", ("export", study, "--format", "csv", "--out", directory / "steps.csv")),
        ("records", ("export", study, "--table", "records", "--format", "jsonl", "--out", directory / "records.jsonl")),
        ("import", ("import", directory / "imported", study)),
        ("compare", ("compare", study, other, "--out", directory / "compare.html")),
    ):
        if name in commands:
            shutil.rmtree(directory / "imported", ignore_errors=True)
            yield name, cost(lockprobe(*words))


def main() -> None:
    """Print the table, row by row."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", default="1000,10000,100000")
    parser.add_argument("--commands", default=",".join(COMMANDS))
    parser.add_argument("--out", type=Path, help="where the studies stay (a temporary directory)")
    asked = parser.parse_args()
    print("| trials | command | seconds | CPU s | CPU ms a trial | MB at most | kB a trial |")
    print("|---|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as temporary:
        for trials in map(int, asked.sizes.split(",")):
            for name, one in costs(asked.out or Path(temporary), trials, asked.commands.split(",")):
                each = f"{1e3 * one.processor / trials:.2f} | {one.memory:.0f} | {1e3 * one.memory / trials:.1f}"
                print(f"| {trials:,} | `{name}` | {one.wall:.1f} | {one.processor:.1f} | {each} |", flush=True)


if __name__ == "__main__":
    main()
