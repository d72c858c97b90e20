"""Makes ``src/lockprobe/statistics/loops/chance_table.json``: exact counts of loop-free sequences.

A *pattern* is a sequence up to the names of its actions (named in order of first appearance). For every
length n and number k of distinct actions the table holds how many patterns hold no action loop of three or
more. With K actions to choose from a pattern of k names stands for K (K-1) ... (K-k+1) sequences, so one
table answers every K whose patterns were all counted.

The count is a depth-first walk in C over all loop-free patterns (about seven minutes on one core)::

    python scripts/make_chance_table.py [--quick] [--out FILE]

A cell is null where it was not counted. Needs a C compiler as ``cc``; nothing compiled is shipped.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

LONGEST = 20
TABLE = Path(__file__).parents[1] / "src" / "lockprobe" / "statistics" / "loops" / "chance_table.json"

REACH = {
    "uniform": ((20, 16), (6, 17), (5, 18), (4, 20)),
    "no-repeat": ((20, 17), (7, 18), (6, 19), (5, 20)),
}
"""Null -> walks (most distinct actions, length); each fills every cell inside its bounds."""

QUICK = {"uniform": ((20, 10), (4, 12)), "no-repeat": ((20, 10), (4, 14))}

SOURCE = r"""
#include <stdint.h>
enum { MOST = 20 };
enum { LAG = 5 };
static int order[MOST + 1], longest, labels, no_repeat;
static uint32_t met[MOST][MOST];
static int64_t (*counts)[MOST + 1];

/* t actions stand in order[], `used` of them distinct. Of a word of three that would start at t - 2,
   met[] knows the copies that start at t - 5 or before, of which none shares an action with it. */
static void walk(int t, int used) {
    uint32_t *cell = 0, before = 0, barred = 0;
    if (t >= LAG) {
        cell = &met[order[t - LAG]][order[t - LAG + 1]];
        before = *cell;
        *cell |= 1u << order[t - LAG + 2];
    }
    if (t >= 2) barred = met[order[t - 2]][order[t - 1]];
    if (t >= 1 && no_repeat) barred |= 1u << order[t - 1];
    uint32_t allowed = ((1u << used) - 1) & ~barred;
    counts[t + 1][used] += __builtin_popcount(allowed);
    if (used < labels) counts[t + 1][used + 1] += 1;
    if (t + 1 < longest) {
        for (; allowed; allowed &= allowed - 1) {
            order[t] = __builtin_ctz(allowed);
            walk(t + 1, used);
        }
        if (used < labels) {
            order[t] = used;
            walk(t + 1, used + 1);
        }
    }
    if (cell) *cell = before;
}

void count(int length, int distinct, int without_repeats, int64_t *into) {
    longest = length; labels = distinct; no_repeat = without_repeats;
    counts = (int64_t (*)[MOST + 1]) into;
    counts[0][0] = 1;
    walk(0, 0);
}
"""


def compiled(directory: Path) -> ctypes.CDLL:
    """The walk as a shared library."""
    source, library = directory / "walk.c", directory / "walk.so"
    source.write_text(SOURCE)
    command = ["cc", "-O3", "-march=native", "-shared", "-fPIC", "-o", str(library), str(source)]
    subprocess.run(command, check=True)  # noqa: S603 - our own source, in our own directory
    return ctypes.CDLL(str(library))


def patterns(walk: ctypes.CDLL, null: str, reach: tuple[tuple[int, int], ...]) -> list[list[int | None]]:
    """Loop-free patterns: row n (0..20), column k (0..n) distinct actions; None where not counted."""
    rows: list[list[int | None]] = [[None] * (n + 1) for n in range(LONGEST + 1)]
    for labels, length in reach:
        begun = time.process_time()
        cells = (ctypes.c_int64 * (LONGEST + 1) ** 2)()
        walk.count(length, labels, int(null == "no-repeat"), cells)
        for n in range(length + 1):
            for k in range(min(n, labels) + 1):
                rows[n][k] = cells[n * (LONGEST + 1) + k]
        sys.stderr.write(f"{null}: up to {labels} actions, length {length}: {time.process_time() - begun:.1f} s\n")
    return rows


def main() -> None:
    """Counts both tables and writes them as one JSON file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="short lengths only (a second)")
    parser.add_argument("--out", type=Path, default=TABLE)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        walk = compiled(Path(directory))
        asked = QUICK if options.quick else REACH
        table = {null: patterns(walk, null, reach) for null, reach in asked.items()}
    lines = [
        f' "{name}": [\n' + ",\n".join(f"  {json.dumps(row)}" for row in rows) + "\n ]" for name, rows in table.items()
    ]
    options.out.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main()
