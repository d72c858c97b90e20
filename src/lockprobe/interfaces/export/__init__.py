"""Exports trials for other tools: tables as CSV, JSON lines or Parquet."""

from __future__ import annotations

from lockprobe.interfaces.export.tidy import COLUMNS, TRIAL_COLUMNS, tidy, tidy_rows, trial_rows

__all__ = ["COLUMNS", "TRIAL_COLUMNS", "tidy", "tidy_rows", "trial_rows"]
