"""A command."""

from pathlib import Path

import lockprobe
from latecomer.untold import untold


def lateness(directory: Path) -> None:
    """Print the share of attempts of which nothing was told, in each condition of a study."""
    trials = lockprobe.load(directory)
    for condition in sorted({trial.condition for trial in trials}):
        shares = [untold(trial) for trial in trials if trial.condition == condition and trial.steps]
        print(f"{condition:20} {sum(shares) / len(shares):.2f}")
