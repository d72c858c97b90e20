"""Trials for other tools: the tables of a study as CSV, JSON lines or Parquet, each with its data dictionary.

``columns.toml`` describes the columns. A table has a row per step or trial, for any statistics package, per call of a
model, or for what people did.
"""

from __future__ import annotations

import csv
import json
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any, Literal

from lockprobe.foundation.errors import BadFile, BadValue, needing
from lockprobe.foundation.storage.atomic_file import atomic_files
from lockprobe.foundation.terminal_text import one_line, readable
from lockprobe.people.diary import Answers, Attempt, Diary, Did, acts_of_steps, read_diaries
from lockprobe.people.experiment import Experiment, kept_experiment
from lockprobe.statistics.loops import cover
from lockprobe.statistics.misinterpretation import claims
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import played
from lockprobe.studies.records.store import read
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Call
from lockprobe.trial.record import Trial
from lockprobe.trial.source import CAMERA, VERDICT

TableName = Literal["steps", "trials", "calls", "participants", "acts", "answers"]

Row = dict[str, object]
"""The values of a row by column; None where one is missing."""

Cell = str | int | float
"""An empty text where a value is missing."""

_COLUMNS: Mapping[str, Mapping[str, Any]] = tomllib.loads(Path(__file__).with_name("columns.toml").read_text("utf-8"))

_FORMULA = ("=", "+", "-", "@", "\t", "\n")
"""Beginnings of cells that a spreadsheet reads as formulas."""

_NONE: Mapping[Any, Any] = MappingProxyType({})


class Table:
    """A table: columns over rows.

    Args:
        name: Its name in ``columns.toml``.
        rows: Gives all rows, as often as it is called.

    Attributes:
        columns: Its columns, each with what describes it; optional ones without a value in any row are left out.
    """

    def __init__(self, name: str, rows: Callable[[], Iterable[Row]]) -> None:
        self._about, self._rows = f"A row is {_COLUMNS['rows'][name]}.", rows
        shared = ("trial", name, "person") if name in ("steps", "trials") else (name,)
        columns = {name: {"kind": "text", **facts} for part in shared for name, facts in _COLUMNS[part].items()}
        empty = {column for column, facts in columns.items() if facts.get("optional")}
        for row in rows() if empty else ():
            empty -= {column for column in empty if _cell(row.get(column)) != ""}
        self.columns = {column: facts for column, facts in columns.items() if column not in empty}

    def rows(self) -> Iterator[dict[str, Cell]]:
        """The cells of each row by column: a mark as 1 or 0, a text without what would steer a terminal."""
        return ({column: _cell(row.get(column)) for column in self.columns} for row in self._rows())

    def write(self, path: Path, kind: Literal["csv", "jsonl", "parquet"]) -> list[Path]:
        """Write the table and its data dictionary (``NAME-metadata.json``), both or neither, and return both paths.

        Raises:
            Missing: If Parquet is asked for and pyarrow is not installed.
            BadFile: If a file cannot be written, or is no regular file.
        """
        beside, described = path.parent / f"{path.name}-metadata.json", list[dict[str, Any]]()
        for column, facts in self.columns.items():
            bounds = {bound: facts[bound] for bound in ("minimum", "maximum") if bound in facts}
            unit = {"schema:unitText": facts["unit"]} if "unit" in facts else {}
            meaning = "1 or 0: " * (facts["kind"] == "mark") + facts["meaning"]
            kept = {"name": column, "titles": column, "dc:description": meaning} | unit
            described.append(kept | {"datatype": _COLUMNS["kinds"][facts["kind"]] | bounds})
        dictionary = {
            "@context": "http://www.w3.org/ns/csvw",
            "url": path.name,
            "dc:description": self._about,
            "tableSchema": {"columns": described},
        }
        with atomic_files(beside, path) as (beside_draft, draft):
            beside_draft.write_text(f"{json.dumps(dictionary, indent=2, ensure_ascii=False)}\n", "utf-8")
            if kind != "parquet":
                with draft.open("w", encoding="utf-8", newline="") as file:
                    self.write_text(file, kind)
                return [path, beside]
            with needing("Parquet files", "parquet"):
                arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
            kinds = {"integer": arrow.int64(), "number": arrow.float64(), "string": arrow.string()}
            schema = arrow.schema([(one["name"], kinds[one["datatype"]["base"]]) for one in described])
            numbers = {one.name for one in schema if one.type != arrow.string()}
            rows = [
                {name: None if name in numbers and cell == "" else cell for name, cell in row.items()}
                for row in self.rows()
            ]
            parquet.write_table(arrow.Table.from_pylist(rows, schema=schema), draft)
        return [path, beside]

    def write_text(self, file: IO[str], kind: Literal["csv", "jsonl"]) -> None:
        """Write CSV or one JSON object per line into a file that is open for text.

        CSV has a header line, configurations with ``b`` in front (``b0110``), so that no program reads them as numbers,
        and no cell that a spreadsheet takes for a formula.
        """
        if kind == "jsonl":
            lines = (json.dumps(row, ensure_ascii=False).encode() for row in self.rows())
            file.writelines(one_line(line).decode() + "\n" for line in lines)
            return
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(self.columns)
        kinds = [facts["kind"] for facts in self.columns.values()]
        writer.writerows(map(_for_csv, kinds, row.values()) for row in self.rows())


def _cell(value: Any) -> Cell:
    if isinstance(value, str):
        return readable(value)
    return "" if value is None else int(value) if isinstance(value, bool) else value


def _for_csv(kind: str, cell: Cell) -> Cell:
    if kind == "bits":
        return f"b{cell}" if cell else ""
    if not isinstance(cell, str):
        return cell
    plain = cell.replace("\r\n", "\n").replace("\r", "\n")
    with suppress(ValueError):  # a number is none, and anything else that begins so is
        float(plain)
        return plain
    return f"'{plain}" if plain.startswith(_FORMULA) else plain


def steps_table(trials: Sequence[Trial], acts: Mapping[tuple[str, int], Did] = _NONE) -> Table:
    """A row per step of finished trials, truth and report.

    A trial that broke before its first step has no row. ``acts`` are those of people, by key of the trial and step.
    """

    def rows() -> Iterator[Row]:
        for trial in trials:
            of_trial = _of_trial(trial)
            labels = dict(zip(trial.joints, trial.labels, strict=True))
            for step, said in zip(trial.steps, trial.said, strict=True):
                did, next_did = (acts.get((trial.key, number)) for number in (step.step, step.step + 1))
                claimed, told = None if said is None else said == "moved", step.told_moved
                row = of_trial | _named(step, "step", "joint", "moved", "told_moved", "chosen", "state")
                row |= {
                    "label": labels[step.joint],
                    "claimed": claimed,
                    "misread": None if claimed is None or told is None else claimed != told,
                    "target": step.moved and step.joint == trial.target,
                    "panel": " ".join(trial.joints),
                    "reply": step.decision.replies[-1] if step.decision.replies else None,
                    "verdict": step.sensed.get(VERDICT),
                    "camera": step.sensed.get(CAMERA),
                }
                if next_did is not None and isinstance(next_did.act, Attempt):
                    row["claimed_rt_ms"] = next_did.act.claimed_rt
                if did is not None:
                    row |= _named(did, "shown", "at") | {"report": step.told, "rt_ms": getattr(did.act, "rt", None)}
                yield row

    return Table("steps", rows)


def trials_table(trials: Sequence[Trial], seconds: Mapping[str, float] = _NONE) -> Table:
    """A row per finished trial, also of those that broke before their first step; ``seconds`` of people, by key."""

    def rows() -> Iterator[Row]:
        for trial in trials:
            loops, said = cover(trial.actions), claims(trial)
            yield _of_trial(trial) | {
                "solved": None if trial.error else trial.solved,
                "steps": len(trial.steps),
                "moves": sum(step.moved for step in trial.steps),
                "false_reports": sum(step.told_falsely for step in trial.steps),
                "claims": len(said),
                "misinterpretations": sum(one.misread for one in said),
                "any_loop": loops.any_loop,
                "loop_coverage": loops.share if trial.steps else None,
                "error": trial.error.boundary if trial.error else None,
                "trial_seconds": seconds.get(trial.key),
            }

    return Table("trials", rows)


def _of_trial(trial: Trial) -> Row:
    person = trial.player.removeprefix(f"{trial.group}:")  # empty if nobody played
    named = _named(trial, "key", "box", "modality", "condition", "p", "repetition", "trial", "ending", "budget")
    theirs = {name: trial.facts.get(name) for name in ("position", "view")} if person else {}
    return named | theirs | {"participant": person, "agent": trial.called or trial.agent}


def _named(one: object, *names: str) -> Row:
    """The columns that are called what an object calls them."""
    return {name: getattr(one, name) for name in names}


def tidy(trials: Trial | Iterable[Trial]) -> list[dict[str, Cell]]:
    """The steps of one or several trials as a table for pandas, polars or R: one row per step, truth and report.

    ``pandas.DataFrame(lockprobe.tidy(trials))``. The columns are those of ``lockprobe export``: ``moved`` (the truth),
    ``told_moved`` (what the report implied), ``claimed`` (what the agent said of this step in its next decision) and
    ``misread`` (whether that contradicts the report) are 0, 1 or empty.
    """
    return list(steps_table(_several(trials)).rows())


def trial_rows(trials: Trial | Iterable[Trial]) -> list[dict[str, Cell]]:
    """One row per trial, including trials that broke before their first step.

    ``solved`` is 1 or 0, and empty if the trial ended as an error, which is not a failure to solve.

    >>> import lockprobe
    >>> (row,) = trial_rows([lockprobe.run_trial(agent="human-inspired", p=0.0, seed=1)])
    >>> row["solved"], row["budget"], row["false_reports"]
    (1, 20, 0)
    """
    return list(trials_table(_several(trials)).rows())


def _several(trials: Any) -> list[Trial]:
    if isinstance(trials, str | Path) or not isinstance(trials, Trial | Iterable):
        raise BadValue("trials", trials, "a trial or several, for example those of lockprobe.load(DIR)")
    return [trials] if isinstance(trials, Trial) else list(trials)


def table_of(directory: Path, name: TableName, *, platform_ids: bool = False) -> Table:
    """A table of the study in a directory. Unfinished trials of people are in the acts, not in the steps.

    ``platform_ids`` keeps what the recruitment platform said of participants.

    Raises:
        BadFile: If a file is damaged, a diary and a record disagree, or the table is of people and nobody took part.
    """
    if name == "calls":
        return Table("calls", lambda: map(_call, read_calls(directory)))
    study = read_study(directory)
    trials, _ = played(directory, study)
    diaries = [kept.without_identity(platform=platform_ids) for kept in read_diaries(directory)]
    acts = acts_of_steps(study, {trial.key: trial for trial in trials}, diaries, directory)
    if name == "steps":
        return steps_table(trials, acts)
    if name == "trials":
        with read(directory) as store:
            seconds = dict(store.rows("select key, round(seconds, 3) from trial where current and player != ''"))
        return trials_table(trials, seconds)
    if not diaries:
        raise BadFile(directory, f"nobody took part in this study, so it has no table of {name}")
    if name != "participants":
        rows = partial(_acts, study, diaries, acts, kept_experiment(directory))
        return Table(name, rows if name == "acts" else lambda: (row for row in rows() if "answer" in row))
    table = Table("participants", lambda: map(_participant, diaries))
    for parameter in sorted({one for kept in diaries for one in kept.joined.platform}):
        means = f"{parameter}, as the recruitment platform gave it in the URL."
        table.columns[f"platform_{parameter}"] = {"kind": "text", "meaning": means}
    return table


def _call(call: Call) -> Row:
    return _named(call, "key", "agent", "step") | {
        "call": call.turn,
        "input_tokens": call.usage.input_tokens,
        "output_tokens": call.usage.output_tokens,
        "call_seconds": call.seconds,
    }


def _participant(kept: Diary) -> Row:
    joined, boxes = kept.joined, range(1, len(kept.joined.slots) + 1)
    left = next((box for box in boxes if box not in kept.endings), None)
    after = None if left is None else len(kept.steps.get(left, ()))
    language, _, texts = joined.words.partition(" ")
    last = max((did.at for did in kept.lines if did.act is not None), default=joined.at)
    return {
        "participant": joined.identity,
        "language": language,
        "texts": texts,
        "boxes_assigned": len(boxes),
        "boxes_finished": sum(kept.endings.get(box) in ("solved", "budget") for box in boxes),
        "boxes_broken": sum(kept.endings.get(box) == "error" for box in boxes),
        "left_in_box": 0 if (left, after) == (1, 0) else left,
        "left_after_step": after,
        "released": kept.late,
        "comprehension_rounds": len(kept.rounds) or None,
        "checks_right": sum(kept.checks),
        "checks_wrong": len(kept.checks) - sum(kept.checks),
        "seconds": round(last - joined.at, 3),
        "conditions": "; ".join(slot.condition for slot in joined.slots),
        "finished": kept.boxes_done and not kept.late,
    } | {f"platform_{name}": value for name, value in joined.platform.items()}


def _acts(
    study: Study, diaries: list[Diary], acts: Mapping[tuple[str, int], Did], experiment: Experiment | None
) -> Iterator[Row]:
    """A row per act, with what the table of acts says of it and what that of answers does."""
    recorded, asked = set(map(id, acts.values())), dict[tuple[str, str], str]()
    if experiment is not None:
        asked |= {("check", str(number)): check.question for number, check in enumerate(experiment.checks, 1)}
        asked |= {("ask", question.name): question.question for question in experiment.questions}
    for kept in diaries:
        keys = {box: kept.plan(study, box).key for box, _ in enumerate(kept.joined.slots, 1)}
        for did in kept.lines:
            if did.scene == "late":
                continue
            row = _named(did, "turn", "at", "right") | {
                "participant": kept.identity,
                "scene": did.scene if did.act else "broken",
                "position": did.box,
                "key": keys.get(did.box or 0),
                "rt_ms": getattr(did.act, "rt", None),
            }
            if isinstance(did.act, Attempt):
                width, height = did.act.viewport or (None, None)
                row |= _named(did, "step", "shown", "ended") | {
                    "label": did.act.joint,
                    "claim": did.act.claimed,
                    "report": did.told,
                    "claim_rt_ms": did.act.claimed_rt,
                    "recorded": id(did) in recorded,
                    "pointer": did.act.pointer,
                    "window_width": width,
                    "window_height": height,
                }
            elif isinstance(did.act, Answers) and did.scene in ("check", "ask"):
                question = asked.get((did.scene, did.item))
                row |= {"name": did.item, "question": question, "answer": did.act.answers[0]}
            yield row
