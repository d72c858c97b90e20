"""The terminal as operator: what counts as an answer, and what ends it."""

import io

import pytest

from lockprobe.plants.operator import ENTER, OperatorStopped, TerminalOperator


def asked(typed, answers, monkeypatch, capsys):
    monkeypatch.setattr("sys.stdin", io.StringIO(typed))
    try:
        return TerminalOperator().ask("Did it move?", answers), capsys.readouterr()
    except OperatorStopped as stopped:
        return stopped, capsys.readouterr()


@pytest.mark.parametrize(
    ("typed", "answers", "answer"),
    [("y\n", "yn", "y"), ("  NO \n", "yn", "n"), ("yes", "yn", "y"), ("\n", (ENTER,), ENTER), ("x\n\ny\n", "yn", "y")],
)
def test_answers(typed, answers, answer, monkeypatch, capsys):
    found, printed = asked(typed, answers, monkeypatch, capsys)
    assert found == answer
    assert printed.out == ""
    assert printed.err.count("Did it move? ") == 1 + printed.err.count("Not an answer here: type y, n, or q to stop.")


@pytest.mark.parametrize(
    ("typed", "why"),
    [("q\n", "the operator stopped"), ("Quit\n", "the operator stopped"), ("", "the input ended before")],
)
def test_q_and_the_end_of_input_stop(typed, why, monkeypatch, capsys):
    found, _ = asked(typed, "yn", monkeypatch, capsys)
    assert isinstance(found, OperatorStopped)
    assert str(found).startswith(why)
