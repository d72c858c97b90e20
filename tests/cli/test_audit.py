"""``lockprobe audit`` and ``lockprobe power``, as typed."""

import json

import pytest
from typed import typed

from lockprobe.prose.hypothesis_tests import QUESTIONS


def test_an_audit_in_words():
    done = typed("audit", "--studies", 4, "--world", "loops-irrelevant", "--world", "loop-trapped", "--workers", 1)
    assert done.returncode == 0, done.stderr
    said = " ".join(done.stdout.split())
    for question in QUESTIONS.values():
        assert question in said
    assert "loops-irrelevant !" in said
    assert "Every recommended test (*) rejects in at most 5 %" in said
    assert "\x1b" not in done.stdout


def test_an_audit_as_json_is_the_same_again_and_a_world_named_twice_is_one():
    done = typed("audit", "--studies", 2, "--world", "no-effect", "--seed", 7, "--workers", 1, "--json")
    found = json.loads(done.stdout)
    assert found["seed"] == 7
    assert list(found["worlds"]) == ["no-effect"]
    assert {"world", "test", "question", "truth", "studies", "rejected", "rate", "error", "valid"} <= set(
        found["rates"][0]
    )
    again = typed("audit", "--studies", 2, *("--world", "no-effect") * 2, "--seed", 7, "--workers", 2, "--json")
    assert again.stdout == done.stdout


def test_power_for_a_stated_effect():
    stated = ("power", "--success", "0.2,0.7", "--p", "0,0.4", "--trials", "9,30", "--studies", 20, "--workers", 1)
    tests = json.loads(typed(*stated, "--json").stdout)["tests"]
    found = next(row for row in tests if row["recommended"] and row["question"] == "success")
    assert [step["trials"] for step in found["measured"]] == [9, 30]
    assert found["trials_needed"] <= 30
    said = typed(*stated).stdout
    assert "trials per flip rate for 0.8" in " ".join(said.split())
    assert "n=30" in said


def test_blocks_of_a_study_of_controls():
    stated = ("power", "why", "--success", "0.2,0.7,0.2", "--trials", "30,150", "--studies", 20)
    small, large = json.loads(typed(*stated, "--json").stdout)["rates"]
    assert (small["blocks"], large["blocks"], large["truth"]) == (30, 150, "says")
    assert large["right"] >= 0.8
    said = typed(*stated).stdout
    assert "as stated" in said
    assert "Arms share no luck here" in said


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("power", "what"), "why, or nothing"),
        (("power", "why", "--success", "0.2,0.5"), "three shares from 0 to 1"),
        (("audit", "--world", "no-efect"), "did you mean 'no-effect'?"),
        (("audit", "--studies", "0"), "--studies"),
        (("power", "--success", "0.2,x"), "numbers separated by commas"),
        (("power", "--harm", "0.5"), "success at each flip rate"),
        (("power", "--success", "0.2,0.7"), "one share for each of 7 flip rates"),
        (("power", "--success", "0.2,1.7", "--p", "0,0.4"), "got 1.7"),
        (("power", "--trials", "1"), "numbers of at least 2"),
        (("power", "--trials", "nan"), "whole numbers"),
        (("power", "--trials", "1e10"), "at most 10000"),
        (("power", "--trials", "1e300"), "at most 10000"),
        (("power", "--trials", ""), "trials: got ''"),
        (("power", "--success", ""), "success: got ''"),
        (("power", "--success", "0.2,0.7", "--p", "0,0.4", "--trap", ""), "trap: got ''"),
        (("power", "--success", "0.2,0.7", "--p", "0.5,0.500000001"), "differ by 0.000001"),
        (("power", "--target", "1.5"), "target power"),
    ],
)
def test_mistakes_are_one_line(arguments, message):
    done = typed(*arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr
    assert done.stderr.count("\n") == 1
