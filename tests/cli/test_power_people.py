"""``lockprobe power --people``."""

import json
import re

import pytest

from lockprobe.simulation.power.people import EFFECT_SD, PERSON_SD, People, people_needed, power_with


def test_it_says_how_many_persons_each_design_needs_and_what_it_assumes(lockprobe):
    _, said, _ = lockprobe("power", "--people", "--success", "0.4,0.6")
    model = People(success=(0.4, 0.6))
    for design in ("within", "between"):
        line = next(line for line in said.splitlines() if line.startswith(f"{design} persons"))
        assert str(people_needed(model, design).people) in line.split()
    assert "chosen by eye" in " ".join(said.split())
    assert f"SD {PERSON_SD:g} and {EFFECT_SD:g}" in said


def test_in_json_the_assumptions_stand_beside_the_numbers(lockprobe):
    asked = ("--success", "0.4,0.6,0.5", "--boxes-each", 2, "--person-sd", 1.5, "--effect-sd", 0.2, "--target", 0.9)
    found = json.loads(lockprobe("power", "--people", *asked, "--json")[1])
    model = People(success=(0.4, 0.6, 0.5), boxes=2, person_sd=1.5, effect_sd=0.2)
    assert (found["boxes"], found["person_sd"], found["effect_sd"], found["target"]) == (2, 1.5, 0.2, 0.9)
    rows = [row for row in found["designs"] if row["person_sd"] == 1.5]
    assert [row["people"] for row in rows] == [people_needed(model, one, 0.9).people for one in ("within", "between")]


def test_for_a_number_of_persons_it_says_their_power_and_the_smallest_effect(lockprobe):
    asked = ("power", "--people", "--success", "0.4,0.6", "--persons", "15,80")
    _, said, _ = lockprobe(*asked)
    model = People(success=(0.4, 0.6))
    lines = [line for line in said.splitlines() if line.startswith("between persons")]
    found = power_with(model, "between", 80)
    assert [line.split()[2] for line in lines] == ["15", "80", "15", "80"]
    assert "too few" in lines[0]
    assert f"{found.power:.2f}" in lines[1].split()
    assert re.search(rf"≤ {found.below - 0.005:.2f}, ≥ {found.above + 0.005:.2f}", lines[3])
    rows = json.loads(lockprobe(*asked, "--json")[1])["designs"]
    few, enough = (row for row in rows if (row["design"], row["person_sd"]) == ("between", PERSON_SD))
    assert (few["people"], few["power"], few["below"]) == (15, None, None)
    assert (enough["people"], enough["power"], enough["above"]) == (80, found.power, found.above)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--people",), "--success is missing, expected the share of boxes opened"),
        (("--people", "--success", "0.4"), "two or more shares"),
        (("why", "--people", "--success", "0.4,0.6"), "--people cannot be combined with why"),
        (("--people", "--success", "0.4,0.6", "--p", "0,0.4", "--trap", "0.5,0.1"), "--p, --trap"),
        (("--boxes-each", "2"), "is for --people"),
        (("--over-boxes", "2", "--success", "0.2,0.4"), "at least 5, for a sentence on boxes like these"),
        (("--over-boxes", "5", "--persons", "40"), "--over-boxes cannot be combined with --persons"),
        (("--over-boxes", "5"), "--success is missing"),
        (("--over-boxes", "5", "--studies", "9"), "--studies is for flip rates alone and conditions and power why"),
        (("--persons", "40"), "is for --people"),
        (("--people", "--success", "0.4,0.6", "--persons", "9"), "10 or more persons"),
        (("--people", "--success", "0.4,0.6", "--persons", "x"), "persons: got 'x'"),
    ],
)
def test_a_mistake_is_one_line(lockprobe, arguments, said):
    code, out, err = lockprobe("power", *arguments)
    assert (code, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1
