"""Makes ``src/lockprobe/statistics/loops/detectors/thresholds.json``: thresholds of scores on a box of four joints.

They are what :func:`lockprobe.statistics.loops.detectors.verdicts.calibrated` computes, which takes a third of a
second for all lengths of usual trials::

    python scripts/make_detector_thresholds.py
"""

from __future__ import annotations

import json
from pathlib import Path

from lockprobe.statistics.loops.detectors import DETECTORS, verdicts

LONGEST = 20
ACTIONS = 4


def main() -> None:
    """Write the table."""
    scores = [detector for detector in DETECTORS if not detector.rule]
    lines = [
        f" {json.dumps(one.name)}: {json.dumps([verdicts.calibrated(one, n, ACTIONS) for n in range(LONGEST + 1)])}"
        for one in scores
    ]
    table = Path(verdicts.__file__).with_name("thresholds.json")
    table.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    print(f"{table}: {len(scores)} scores")


if __name__ == "__main__":
    main()
