"""How cells of the leaderboard are written."""

import math
from dataclasses import replace
from types import SimpleNamespace

from lockprobe.analysis.agent_comparison.leaderboard_row import Regret
from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.proportions import Proportion
from lockprobe.formatting import NONE
from lockprobe.report.leaderboard import AdjustedPairs, ComparisonByDose, MoneyResult
from lockprobe.report.leaderboard_tables import (
    comparison_by_p_table,
    comparison_table,
    interaction_table,
    leaderboard_table,
)

SHARE = Proportion(count=5, n=10, value=0.5, low=0.4, high=0.6)
NONE_READ = Proportion(count=0, n=0, value=math.nan, low=0.0, high=1.0)
MONEY = MoneyResult(
    calls=None, uncounted_calls=0, input_tokens=None, cached_share=None, output_tokens=None, reasoning_tokens=None,
    dollars=None, dollars_per_solved=None,
)  # fmt: skip
ROW = SimpleNamespace(
    rank_low=2, rank_high=2, label="a", trials=10, success=SHARE, steps_to_80=None,
    regret=Regret(value=1.2, low=None, high=None), loops_above_chance=-0.204, misread=NONE_READ, not_asked=3,
    money=MONEY,
)  # fmt: skip


def row_with(**changed):
    return SimpleNamespace(**vars(ROW) | changed)


def test_what_is_missing_is_said_or_a_dash():
    head, row = leaderboard_table([ROW])
    assert row == [
        "2",
        "a",
        "10",
        "50 % [40, 60]",
        "not reached",
        "\N{MINUS SIGN}0.20",
        "\N{MINUS SIGN}20",
        "not asked",
    ]
    assert len(head) == len(row)
    never = leaderboard_table([row_with(not_asked=0, rank_low=None, loops_above_chance=None, regret=None)])[1]
    assert [never[i] for i in (0, 5, 6, 7)] == [NONE] * 4


def test_money_has_columns_only_where_tokens_were_counted():
    spent = replace(
        MONEY, input_tokens=1000, cached_share=0.25, output_tokens=10, dollars=1.5, dollars_per_solved=0.001234
    )
    head, *rows = leaderboard_table([ROW, row_with(money=spent)])
    assert head[-5:] == ["tokens in", "cached", "tokens out", "US$", "US$ per solved trial"]
    assert rows[0][-5:] == [NONE] * 5
    assert rows[1][-5:] == ["1000", "25 %", "10", "1.50", "0.0012"]


def test_money_is_a_lower_bound_where_some_replies_were_not_counted_and_empty_where_none_was():
    some = replace(MONEY, uncounted_calls=3, input_tokens=1000, output_tokens=10, dollars=0.00001)
    _, *rows = leaderboard_table([row_with(money=some), row_with(money=replace(MONEY, uncounted_calls=3))])
    assert rows[0][-2:] == ["at least 0.00001", NONE]
    assert rows[1][-5:] == [NONE] * 5


def test_two_that_play_alike_at_every_p_have_one_row():
    found = AdjustedPairs(n=10, only_first=1, only_second=2, value=0.1, low=-0.1, high=0.3, p_value=1.0, p_adjusted=1.0)
    steps = BlockMean(value=-1.0, low=None, high=None, p_value=None, pairs=10, blocks=10)
    by_p = [ComparisonByDose(p=p, success=found, steps=steps) for p in (0.0, 0.3)]
    pair = {"first_label": "a", "second_label": "b", "by_p": by_p}
    table = comparison_by_p_table([SimpleNamespace(**pair, same_at_every_p=same) for same in (True, False)])
    assert [row[2] for row in table[1:]] == ["every flip rate", "0", "0.3"]


def test_no_pairs_make_a_table_of_a_head_alone():
    assert [len(table([])) for table in (comparison_table, interaction_table)] == [1, 1]
    assert not math.isnan(len(leaderboard_table([])))
