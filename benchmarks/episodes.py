"""The report of 10 000 episodes of 40 tasks, 5 agents and 2 conditions, 68 % of them matched, against reading the file.

``uv run python benchmarks/episodes.py``
"""

import csv
import subprocess
import sys
import tempfile
import time
from pathlib import Path

EXAMPLE = Path(__file__).parents[1] / "examples" / "episodes.py"


def main() -> None:
    """Make the table by the example, report it by the command, and print both times."""
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "episodes.csv"
        subprocess.run([sys.executable, EXAMPLE, table, "40", "25", "8"], check=True)
        began = time.perf_counter()
        with table.open(newline="", encoding="utf-8") as file:
            rows = sum(1 for _ in csv.DictReader(file))
        read = time.perf_counter() - began
        command = [sys.executable, "-m", "lockprobe", "report", table, "--out", Path(folder) / "report"]
        began = time.perf_counter()
        subprocess.run(command, check=True)
        print(f"{rows} episodes: {time.perf_counter() - began:.1f} s for the page, {read:.2f} s to read the file")


if __name__ == "__main__":
    main()
