"""The tables of a report, as rows of text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, cast, get_args

from lockprobe.analysis.clustered import ClusteredProportion
from lockprobe.analysis.inference.course import CourseKind
from lockprobe.analysis.proportions import Proportion
from lockprobe.formatting import NONE, bracketed, minus, p_cell, percent, share
from lockprobe.prose.success import course_said
from lockprobe.report import details
from lockprobe.report.format import DETECTED, EVERY, TextTable, share_cell
from lockprobe.report.schema import ConditionResult, CrossingResult, EffectResult

__all__ = [
    "claim_table",
    "condition_table",
    "course_table",
    "crossing_table",
    "detector_table",
    "effect_table",
    "loop_table",
    "modality_table",
    "pace_table",
    "rationality_table",
    "speed_table",
    "table1",
    "table1_corrected",
    "table_of_conditions",
]

_AGAINST = "against the rules"


def table1(conditions: Sequence[ConditionResult]) -> TextTable:
    """The paper's Table 1, one row per condition.

    The paper's rows are modalities, and so are these where a study compares them; else a row names its flip rate too.
    The paper marks a total by one asterisk or two for the number of trials that it occurred in; here words say so,
    since asterisks read as levels of significance.
    """
    asked = [row for row in conditions if row.misinterpretation_trials]
    counts = [(row.misinterpretation_trials_affected, row.misinterpretation_trials) for row in asked]
    first = "Input Modality" if _one_p(asked) and len({row.modality for row in asked}) > 1 else "Agent and condition"
    table = [[first, "Average State Misinterpretation Rate per Trial", "Total State Misinterpretations"]]
    return table + [
        [
            _named(row, asked),
            percent(row.misinterpretation_rate, 1) + _plus_minus(row.misinterpretation_rate_sd),
            f"{row.misinterpretations}, in {affected} of {of} trials",
        ]
        for row, (affected, of) in zip(asked, counts, strict=True)
    ]


def table1_corrected(conditions: Sequence[ConditionResult]) -> TextTable:
    """The three errors of claims, pooled over claims, with intervals clustered by trial."""
    head = ["agent and condition", "claims", "misread", "claimed moved, told blocked", "claimed blocked, told moved"]
    table = [[*head, "false report", "false belief", "false reports believed"]]
    asked = [row for row in conditions if row.misinterpretation_trials]
    return table + [
        [
            _named(row, asked),
            str(row.claims),
            share_cell(row.misread),
            _of(row.said_moved_told_blocked),
            _of(row.said_blocked_told_moved),
            share_cell(row.false_report),
            share_cell(row.false_belief),
            _of(row.false_reports_believed),
        ]
        for row in asked
    ]


def speed_table(conditions: Sequence[ConditionResult]) -> TextTable:
    """How fast the box is solved, between chance and the optimum."""
    head = ["agent", _varied(conditions), "mean steps", "median step", "80 % by step", "relative area"]
    table = [head]
    for row, p in _distinct(conditions):
        relative, (early, late) = row.relative, row.steps_to_80_interval
        table.append(
            [
                row.label,
                p,
                NONE if row.mean_steps_all is None else f"{row.mean_steps_all:.1f}",
                _step(row.median_steps_all),
                NONE
                if row.steps_to_80 is None and early is None
                else f"{_step(row.steps_to_80)} [{_step(early)}, {_step(late)}]",
                NONE if relative is None else minus(f"{relative.value:.2f} [{relative.low:.2f}, {relative.high:.2f}]"),
            ]
        )
    return table


def pace_table(paces: Sequence[details.PaceResult]) -> TextTable:
    """Every two agents at the same p: who is faster."""
    return [
        [
            "agent",
            "compared with",
            "flip rate",
            "hazard ratio of solving",
            "log-rank",
            "log-rank, not clustered",
            "Gehan",
        ]
    ] + [
        [
            row.second_label,
            row.first_label,
            f"{row.p:g}",
            NONE if row.hazard_ratio is None else f"{row.hazard_ratio:.2f}",
            *map(p_cell, (row.p_value, row.independent, row.gehan)),
        ]
        for row in paces
    ]


def modality_table(effects: Sequence[details.ModalityResult]) -> TextTable:
    """Every two modalities of each agent, and the trend over fidelity."""
    head = ["agent", "compared with", "hazard ratio of solving", "log-rank", "corrected (Holm)"]
    table = [[*head, "solved only with the first", "solved only with the second", "McNemar"]]
    for row in effects:
        words = dict(zip(row.modalities, row.spoken, strict=True))
        for pair in row.pairs:
            ratio, final = pair.hazard_ratio, pair.final
            table.append(
                [
                    f"{row.agent} ({words[pair.second]})",
                    words[pair.first],
                    NONE if ratio is None else f"{ratio:.2f}",
                    *map(p_cell, (pair.p_value, pair.p_adjusted)),
                    str(final.only_second),
                    str(final.only_first),
                    f"{final.p_value:.2g}",
                ]
            )
    return table


def loop_table(conditions: Sequence[ConditionResult]) -> TextTable:
    """Loop rates and their chance levels under four null models."""
    head = ["agent", _varied(conditions), "trials with a loop", "uniform", "without repeats", "own transitions"]
    return [[*head, "own actions shuffled", "equal outcomes", "equal states"]] + [
        [
            row.label,
            p,
            share(row.loop_rate, row.loop_rate_low, row.loop_rate_high),
            percent(row.loop_rate_chance, 0),
            percent(row.loop_rate_chance_no_repeat, 0),
            percent(row.loop_rate_chance_markov, 0),
            percent(row.loop_rate_chance_permutation, 0),
            *(percent(row.loop_rate_by_symbol.get(name), 0) for name in ("action-outcome", "state-action")),
        ]
        for row, p in _distinct(conditions)
    ]


def detector_table(rows: Sequence[details.DetectorResult]) -> TextTable:
    """The share of trials that each detector flags."""
    names = list(dict.fromkeys(name for row in rows for name in row.flagged))
    return [["agent", _varied(rows), *names]] + [
        [row.label, _under(row, rows), *(percent(row.flagged.get(name), 0) for name in names)] for row in rows
    ]


def condition_table(conditions: Sequence[ConditionResult]) -> TextTable:
    """One row per condition. Intervals are 95 % Wilson; chance is for trials of exactly those lengths."""
    head = ["agent", "modality", "flip rate", "trials", "solved", "success", "loop rate", "by chance", "coverage"]
    table = [[*head, "redundant", _AGAINST, "errors"]]
    table += [
        [
            row.agent,
            row.modality,
            f"{row.p:g}",
            str(row.trials),
            str(row.solved),
            share(row.success, row.success_low, row.success_high),
            share(row.loop_rate, row.loop_rate_low, row.loop_rate_high),
            f"{percent(row.loop_rate_chance, 0)} to {percent(row.loop_rate_chance_no_repeat, 0)}",
            percent(row.coverage, 0),
            percent(row.redundant_share, 0),
            _against(row),
            str(row.broken),
        ]
        for row in conditions
    ]
    table = _without_empty(table, _AGAINST)
    return table if len({row[1] for row in table[1:]}) > 1 else [[row[0], *row[2:]] for row in table]


def course_table(courses: Sequence[details.CourseResult]) -> TextTable:
    """The course of success and of the loop rate over the flip rate, one row per agent."""
    head = ["agent", "solved at the lowest flip rate", "highest", "lowest", "solved at the highest flip rate"]
    loops = ["loops at the lowest flip rate", "fewest loops", "loops at the highest flip rate", "loops begin"]
    return [[*head, "course of success", *loops]] + [
        [
            row.label,
            percent(row.first, 0),
            f"{percent(row.highest, 0)} at {row.highest_p:g}",
            f"{percent(row.lowest, 0)} at {row.lowest_p:g}",
            percent(row.last, 0),
            _course(row.kind),
            *(percent(share, 0) for share in (row.loops_first, row.loops_least, row.loops_last)),
            _detected(row.looping),
        ]
        for row in courses
    ]


def _detected(kind: str) -> str:
    return "no change detected" if kind == "no change detectable" else kind


def _course(kind: str) -> str:
    return course_said(cast("CourseKind", kind)) if kind in get_args(CourseKind) else kind


def rationality_table(rows: Sequence[details.RationalityResult]) -> TextTable:
    """How rational actions were for the observer that believes reports and for the other; in brackets by chance."""
    head = ["agent", _varied(rows)]
    head += [f"{what}, reports {how}" for how in ("believed", "doubted") for what in ("optimal", "steps lost")]
    table = [[*head, "uninformative attempts", "bits, of the maximum", "bits left at the end"]]
    naive, aware = ([row for row in rows if row.noise == noise] for noise in ("naive", "aware"))
    blind = {(row.agent, row.modality): row for row in reversed(naive) if row.same_at_every_p}
    for one, two in zip(naive, aware, strict=True):
        if one.same_at_every_p and blind[one.agent, one.modality] is not one:
            continue
        cells = [
            cell
            for row in (one, two)
            for cell in (_with_chance(row.optimal, row.by_chance["optimal"]), _steps_lost(row))
        ]
        bits = f"{two.expected:.2f} of {two.best:.2f}"
        cells += [_with_chance(two.uninformative, two.by_chance["uninformative"]), bits, f"{two.entropy_left:.1f}"]
        table.append([one.label, _under(one, rows), *cells])
    return table


def _with_chance(share: ClusteredProportion, chance: float) -> str:
    return f"{share_cell(share)} ({percent(chance, 0)})"


def _steps_lost(row: details.RationalityResult) -> str:
    return f"{row.regret.value:.2f} ({row.by_chance['regret']:.2f})"


def claim_table(claims: Sequence[details.ClaimResult]) -> TextTable:
    """The paper's claims and what was measured."""
    names = ["place", "quote", "paper", "recomputed", "agent", "here", "verdict", "test"]
    head = ["place", "quote", "paper", "reanalysis", "agent", "this study", "verdict", "test", "P"]
    return [head] + [[*(getattr(row, name) for name in names), p_cell(row.p_value)] for row in claims]


def _distinct(conditions: Sequence[ConditionResult]) -> list[tuple[ConditionResult, str]]:
    """Conditions with their flip rate or name; of an agent that plays the same at every flip rate only the first."""
    once = {(row.agent, row.modality): row for row in reversed(conditions) if row.same_at_every_p}
    return [
        (row, EVERY if row.same_at_every_p else _under(row, conditions))
        for row in conditions
        if not row.same_at_every_p or once[row.agent, row.modality] is row
    ]


def _named(row: ConditionResult, among: Sequence[ConditionResult]) -> str:
    """A condition's name; its flip rate goes without saying where modalities are compared at one."""
    modal = _one_p(among) and len({other.modality for other in among}) > 1
    under = row.condition if _of_conditions(among) else f"flip rate {row.p:g}"
    return str(row.label) if modal else f"{row.label}, {under}"


def _one_p(rows: Sequence[ConditionResult]) -> bool:
    return len({row.p for row in rows}) == 1 and not _of_conditions(rows)


class _Row(Protocol):
    """A row under one condition."""

    @property
    def condition(self) -> str: ...
    @property
    def p(self) -> float | None: ...
    @property
    def label(self) -> str: ...


def _of_conditions(rows: Sequence[_Row]) -> bool:
    """Whether flip rates do not tell the rows apart: then all go by the names of their conditions."""
    rates = {(row.label, row.p) for row in rows}
    return None in {p for _, p in rates} or len(rates) < len({(row.label, row.condition) for row in rows})


def _varied(rows: Sequence[_Row]) -> str:
    return "condition" if _of_conditions(rows) else "flip rate"


def _under(row: _Row, among: Sequence[_Row]) -> str:
    return row.condition if _of_conditions(among) else f"{row.p:g}"


def _plus_minus(value: float | None) -> str:
    return "" if value is None else f" ± {percent(value, 1)}"


def _step(step: float | None) -> str:
    return NONE if step is None else f"{step:g}"


def _of(count: details.CountOf | Proportion | ClusteredProportion) -> str:
    return f"{count.count} of {count.n}"


def effect_table(effects: Sequence[EffectResult]) -> TextTable:
    """Every condition against the control, in the trials that both have."""
    head = ["agent", "condition", "control", "solved, control", "solved", "difference, points", "P", "conclusion"]
    return [head] + [
        [
            row.agent,
            row.condition,
            row.control,
            f"{row.control_solved} of {row.trials}",
            f"{row.solved} of {row.trials}",
            bracketed(row.difference, row.difference_low, row.difference_high),
            p_cell(row.p_value),
            DETECTED[row.detectable],
        ]
        for row in effects
    ]


def crossing_table(crossings: Sequence[CrossingResult]) -> TextTable:
    """The interaction of every two interventions that were also combined."""
    head = ["agent", "first", "second", "both", "interaction, points", "P", "conclusion"]
    return [head] + [
        [
            row.agent,
            row.first,
            row.second,
            row.both,
            bracketed(row.difference, row.difference_low, row.difference_high),
            p_cell(row.p_value),
            DETECTED[row.detectable],
        ]
        for row in crossings
    ]


def table_of_conditions(conditions: Sequence[ConditionResult]) -> TextTable:
    """Every agent under every condition. Intervals are 95 % Wilson; chance is for trials of exactly those lengths."""
    head = [
        "agent",
        "condition",
        "interventions",
        "modality",
        "trials",
        "success",
        "mean steps",
        "loop rate",
        "by chance",
    ]
    table = [[*head, "misread", "false reports", "changed steps", _AGAINST, "errors"]]
    table += [
        [
            row.agent,
            row.condition,
            row.acts or NONE,
            row.modality,
            str(row.trials),
            _share_with_signs(row.success, row.success_low, row.success_high),
            NONE if row.mean_steps_all is None else f"{row.mean_steps_all:.1f}",
            _share_with_signs(row.loop_rate, row.loop_rate_low, row.loop_rate_high),
            f"{percent(row.loop_rate_chance, 0)} to {percent(row.loop_rate_chance_no_repeat, 0)}",
            percent(row.misread.value, 1) if row.claims else NONE,
            percent(row.false_report_of_all_steps.value, 1),
            NONE if row.changed_steps is None else f"{row.changed_steps} of {row.steps}",
            _against(row),
            str(row.broken),
        ]
        for row in conditions
    ]
    said = {row[2] for row in table[1:]} - {NONE}
    kept = [i for i in range(len(table[0])) if _says_something(table, i) or i not in (2, 3)]
    if said <= {row[1] for row in table[1:]}:
        kept = [i for i in kept if i != 2]  # unnamed conditions are called by their interventions
    return _without_empty([[row[i] for i in kept] for row in table], _AGAINST)


def _without_empty(table: TextTable, name: str) -> TextTable:
    """The table without a column that says nothing."""
    at = table[0].index(name)
    return table if {row[at] for row in table[1:]} - {NONE} else [[*row[:at], *row[at + 1 :]] for row in table]


def _against(row: ConditionResult) -> str:
    """How many attempts broke the rules of the box, if any did."""
    return f"{row.rules.against} of {row.rules.attempts}" if row.rules and row.rules.against else NONE


def _says_something(table: TextTable, column: int) -> bool:
    return len({row[column] for row in table[1:]}) > 1


def _share_with_signs(value: float | None, low: float | None, high: float | None) -> str:
    return NONE if value is None else f"{percent(value, 0)} [{percent(low, 0)}, {percent(high, 0)}]"
