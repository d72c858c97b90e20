"""Text that is safe to print in a terminal."""

from lockprobe.foundation.errors import BadFile, UserMistake
from lockprobe.foundation.terminal_text import readable


def test_an_error_steers_no_terminal_and_is_one_line():
    assert str(BadFile("x\x1b[2J\u202ey", "a\nb\x07")) == "x?[2J?y: a b?"
    assert str(UserMistake("no such key\x9b31m")) == "no such key?31m"


def test_texts_keep_their_script_and_lose_what_steers():
    assert readable("a\r\n\tb") == "a\r\n\tb"
    persian = "\u0645\u06cc\u200c\u062e\u0648\u0631\u0645 👨\u200d👩\u200f"
    assert readable(persian) == persian
    assert readable("a\x1b[31m\x00\u202ecod\u2066\x9b\u2028") == "a?[31m??cod???"
