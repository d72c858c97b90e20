"""How cells of the leaderboard are written."""

import math

from lockprobe.formatting import NONE
from lockprobe.report.leaderboard_tables import (
    comparison_by_p_table,
    comparison_table,
    interaction_table,
    leaderboard_table,
)

SHARE = {"value": 0.5, "low": 0.4, "high": 0.6, "n": 10}
MONEY = {
    "uncounted_calls": 0, "input_tokens": None, "cached_share": None, "output_tokens": None, "dollars": None,
    "dollars_per_solved": None,
}  # fmt: skip
ROW = {
    "rank_low": 2, "rank_high": 2, "label": "a", "trials": 10, "success": SHARE, "steps_to_80": None,
    "regret": {"value": 1.2, "low": None, "high": None}, "loops_above_chance": -0.204, "misread": SHARE | {"n": 0},
    "not_asked": 3, "money": MONEY,
}  # fmt: skip


def test_what_is_missing_is_said_or_a_dash():
    head, row = leaderboard_table([ROW])
    assert row == ["2", "a", "10", "50 % [40, 60]", "not reached", "1.20", "\N{MINUS SIGN}20", "not asked"]
    assert len(head) == len(row)
    never = leaderboard_table([ROW | {"not_asked": 0, "rank_low": None, "loops_above_chance": None, "regret": None}])[1]
    assert [never[i] for i in (0, 5, 6, 7)] == [NONE] * 4


def test_money_has_columns_only_where_tokens_were_counted():
    spent = MONEY | {"input_tokens": 1000, "cached_share": 0.25, "output_tokens": 10, "dollars": 1.5}
    head, *rows = leaderboard_table([ROW, ROW | {"money": spent | {"dollars_per_solved": 0.001234}}])
    assert head[-5:] == ["tokens in", "cached", "tokens out", "US$", "US$ per solved trial"]
    assert rows[0][-5:] == [NONE] * 5
    assert rows[1][-5:] == ["1000", "25 %", "10", "1.50", "0.0012"]


def test_money_is_a_lower_bound_where_some_replies_were_not_counted_and_empty_where_none_was():
    some = MONEY | {"uncounted_calls": 3, "input_tokens": 1000, "output_tokens": 10, "dollars": 0.00001}
    _, *rows = leaderboard_table([ROW | {"money": some}, ROW | {"money": MONEY | {"uncounted_calls": 3}}])
    assert rows[0][-2:] == ["at least 0.00001", NONE]
    assert rows[1][-5:] == [NONE] * 5


def test_two_that_play_alike_at_every_p_have_one_row():
    found = {
        "n": 10,
        "only_first": 1,
        "only_second": 2,
        "value": 0.1,
        "low": None,
        "high": None,
        "p_value": 1.0,
        "p_adjusted": 1.0,
    }
    by_p = [{"p": p, "success": found, "steps": {"value": -1.0, "low": None, "high": None}} for p in (0.0, 0.3)]
    pair = {"first_label": "a", "second_label": "b", "by_p": by_p}
    table = comparison_by_p_table([pair | {"same_at_every_p": True}, pair | {"same_at_every_p": False}])
    assert [row[2] for row in table[1:]] == ["every flip rate", "0", "0.3"]


def test_no_pairs_make_a_table_of_a_head_alone():
    assert [len(table([])) for table in (comparison_table, interaction_table)] == [1, 1]
    assert not math.isnan(len(leaderboard_table([])))
