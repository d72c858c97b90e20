"""``lockprobe chance``, as typed."""

import json
from functools import partial

import pytest
from typed import in_process

from lockprobe.foundation.errors import BadFile, Conflict
from lockprobe.statistics.loops.chance import chance_level

TRIALS = "ABCABCABC\nA B C D\n\nABDCABDDCBA\n"

ask = partial(in_process, "chance")


def test_the_level_of_a_length():
    found = json.loads(ask("--length", 10, "--null", "no-repeat", "--overlap", "--json").output)
    level = chance_level(10, null="no-repeat", overlap=True)
    assert found == {"probability": level.probability, "method": "exact", "error": 0.0}
    assert ask("--length", 12, "--min-length", 2).output.startswith(
        f"{chance_level(12, min_length=2).probability:.4f} "
    )
    assert ask().output == "0.8008 (exact; uniform, 20 steps, 4 joints)\n"


@pytest.mark.parametrize("null", ["uniform", "no-repeat"])
def test_the_level_of_sequences(null, tmp_path):
    (tmp_path / "trials.txt").write_text(TRIALS)
    words = ("--null", null, "--json", "--sequences")
    found = json.loads(ask(*words, tmp_path / "trials.txt").stdout)
    assert set(found) == {"probability", "method", "error"}
    assert 0 < found["probability"] < 1
    assert (found["method"], found["error"]) == ("exact", 0)
    assert json.loads(ask(*words, "-", stdin=TRIALS).stdout) == found
    assert "the lengths of 3 trials" in ask("--null", null, "--sequences", "-", stdin=TRIALS).stdout
    assert ask(*words, "-", stdin=TRIALS).stderr == "1 empty line skipped\n"


def test_what_cannot_be_read_is_refused(tmp_path):
    with pytest.raises(BadFile, match="no action sequence"):
        ask("--sequences", "-", stdin="\n \n")
    with pytest.raises(BadFile, match="cannot be read"):
        ask("--sequences", tmp_path / "none.txt")
    (tmp_path / "other").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BadFile, match="UTF-8"):
        ask("--sequences", tmp_path / "other")
    with pytest.raises(BadFile, match="-: all lines: 8 distinct actions, but --actions is 4"):
        ask("--sequences", "-", stdin="ABCD\nEFGH")
    with pytest.raises(BadFile, match="70 distinct actions, at most 64 are possible"):
        ask("--sequences", "-", stdin=" ".join(map(str, range(70))))
    assert ask("--null", "other").exit_code == 2


def test_sequences_have_their_own_lengths():
    for length in (0, 20):
        with pytest.raises(Conflict, match="--length cannot be combined with --sequences"):
            ask("--sequences", "-", "--length", length, stdin=TRIALS)
    assert ask("--length", 0).output.startswith("0.0000 (exact; uniform, 0 steps")
