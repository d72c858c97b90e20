"""Trials for other tools: tidy steps as CSV, JSON lines, Parquet, and people's trials as a Psych-DS dataset."""

from __future__ import annotations

from lockprobe.export.tidy import COLUMNS, tidy_rows, write_csv, write_jsonl, write_parquet

__all__ = ["COLUMNS", "tidy_rows", "write_csv", "write_jsonl", "write_parquet"]
