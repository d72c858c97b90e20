"""One row a trial: what it came to, an error never as a failure."""

from builders import SOLUTION, make_trial

from lockprobe.export import TRIAL_COLUMNS, trial_rows


def test_rows_by_hand():
    solved = make_trial(SOLUTION, p=0.4, false_at=[2], claims=[None, "moved", "moved", "moved"])
    looping = make_trial([0, 0, 0, 0, 0, 0])
    broken = make_trial([], broken="model")
    rows = list(trial_rows([solved, looping, broken]))
    assert all(tuple(row) == TRIAL_COLUMNS for row in rows)
    found = [
        (row["ending"], row["solved"], row["steps"], row["moves"], row["false_reports"], row["claims"],
         row["misinterpretations"], row["any_loop"], row["loop_coverage"], row["error"])
        for row in rows
    ]  # fmt: skip
    assert found == [
        ("solved", 1, 4, 4, 1, 3, 1, 0, 0.0, ""),
        (looping.ending, 0, 6, 0, 0, 0, 0, 1, 1.0, ""),
        ("error", "", 0, 0, 0, 0, 0, 0, "", "model"),
    ]
