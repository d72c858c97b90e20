"""Exports trials for other tools: tables as CSV, JSON lines or Parquet."""

from __future__ import annotations

from lockprobe.interfaces.export.study_tables import tidy, trial_rows

__all__ = ["tidy", "trial_rows"]
