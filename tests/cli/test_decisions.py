"""What a run until decided says at its end, and what ``lockprobe status`` says of it."""

import json

ASKED = ("run", "flips", "--agent", "careful=human-inspired", "--p", "0,0.9", "--most", "40")


def test_a_run_and_its_status_say_what_is_decided(lockprobe, tmp_path):
    directory = tmp_path / "a"
    status, said, _ = lockprobe(*ASKED, "--until", "decided", "--no-report", "--out", directory)
    assert status == 0
    said = said.splitlines()
    (first,) = [line for line in said if line.startswith("1 of 1 difference decided")]
    (each,) = [line for line in said if line.startswith("  careful, flip?p=0.9: an effect (block ")]
    assert first.endswith("of at most 80 trials")
    assert any("at most 40 trials per condition, looking after every 5 blocks," in line for line in said)
    status = lockprobe("status", str(directory))[1]
    assert f"decided     {first}" in status
    assert each.strip() in status
    facts = json.loads(lockprobe("status", str(directory), "--json")[1])
    (one,) = facts["decided"]
    value, first, second = (f"{100 * x:+.0f}".replace("-", "\N{MINUS SIGN}") for x in (one["value"], *one["halves"]))
    assert each.endswith(f"); {value} points, {first} in the first half of the blocks and {second} in the second")
    assert (one["agent"], one["difference"], one["verdict"]) == ("careful", "flip?p=0.9", "effect")
    assert one["block"] <= one["blocks"] < 40
    assert facts["owed"] == 0
    assert facts["done"] == facts["trials"] == 2 * one["blocks"]
    lines = lockprobe(*ASKED, "--until", "decided", "--no-report", "--out", str(directory), "--json")[1].splitlines()
    (event,) = [one for line in lines if (one := json.loads(line))["event"] == "decided"]
    assert event["message"].startswith("1 of 1 difference decided")
    assert event["answers"][0]["verdict"] == "effect"
