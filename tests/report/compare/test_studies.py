"""Studies side by side: the numbers are those of the records, and what cannot be compared is refused."""

from dataclasses import replace

import pytest
from builders import play_study, small_study, write_study

from lockprobe.foundation.errors import BadFile, UnknownName
from lockprobe.interventions.conditions import read_condition
from lockprobe.report.compare.studies import compare_studies
from lockprobe.statistics.proportions import proportion
from lockprobe.studies.records.read_records import load

AGENTS = ("cognitive:careful", "random")
A = small_study(agents=AGENTS)
B = replace(A, agents=("cognitive:perseverant", "random"), conditions=small_study(p=(0.3, 0.0, 0.9)).conditions)
C = replace(B, seed=7)


@pytest.fixture(scope="module")
def labs(tmp_path_factory):
    root = tmp_path_factory.mktemp("labs")
    half = play_study(C)[:20]
    return [
        write_study(root / "one" / "study", A),
        write_study(root / "two" / "study", B),
        write_study(root / "half", C, half),
    ]


@pytest.fixture(scope="module")
def found(labs):
    return compare_studies(labs)


def test_success_is_counted_from_the_records_of_the_conditions_that_two_studies_share(labs, found):
    counted = {}
    for number, directory in enumerate(labs):
        for trial in load(directory):
            name = f"flip?p={trial.p:g}" if trial.p else "truth"
            if name != "flip?p=0.6":
                solved = counted.setdefault((name, number, trial.agent), [])
                solved.append(trial.solved)
    assert {(row.condition, *row.side[:2]): row.success for row in found.success} == {
        key: proportion(sum(solved), len(solved)) for key, solved in counted.items()
    }
    assert [row.condition for row in found.success[:2]] == ["truth", "truth"]


def test_every_two_sides_are_compared_and_luck_is_shared_by_seed(found):
    assert [one.name for one in found.studies] == ["one/study", "two/study", "half"]
    for one in found.differences:
        assert one.paired == (2 not in {one.first.study, one.second.study} or one.first.study == one.second.study)
    same = next(one for one in found.differences if one.first == (0, "random", "") and one.second == (1, "random", ""))
    assert (same.value, same.p_value) == (0.0, 1.0)  # one seed, and an agent that plays by the seed
    assert found.studies[0].not_shared == ("flip?p=0.6",)
    assert not found.studies[1].not_shared


def test_partial_studies_are_said_to_be(labs, found):
    assert [(one.partial, one.finished, one.planned) for one in found.studies] == [
        (False, 48, 48),
        (False, 48, 48),
        (True, 20, 48),
    ]
    assert [one["partial"] for one in found.plain()["studies"]] == [False, False, True]
    assert len(load(labs[2])) == 20


def test_an_agent_is_chosen_and_one_that_nobody_has_is_refused(labs, found):
    chosen = compare_studies(labs[:2], ["random"])
    assert {row.side.agent for row in chosen.success} == {"random"}
    assert {one.kind for one in chosen.differences} == {"between"}  # without others, baselines are what it is about
    with pytest.raises(UnknownName, match="no agent of these studies is called 'rando'"):
        compare_studies(labs, ["rando"])


def test_agents_of_one_name_that_are_not_the_same_are_told_apart(tmp_path):
    study = small_study(agents=("llm:a",), p=(0.0,), repetitions=1, trials=2)
    played = play_study(replace(study, agents=("random",)))

    def lab(name, prompt):
        trials = [
            replace(trial, agent="llm:a", key=trial.key.replace("random", "llm:a"), facts={"prompt": prompt, "seed": 3})
            for trial in played
        ]
        return write_study(tmp_path / name, study, trials)

    found = compare_studies([lab("a", "ab12"), lab("b", "cd34")])
    assert found.unlike == ("llm:a: prompt is ab12 in a, cd34 in b",)


def test_what_cannot_be_compared_is_refused(labs, tmp_path):
    with pytest.raises(BadFile, match="given twice"):
        compare_studies([labs[0], labs[0] / ".." / "study"])
    with pytest.raises(BadFile, match=r"no study\.json here"):
        compare_studies([labs[0], tmp_path])
    longer = write_study(tmp_path / "longer", replace(A, max_steps=5), [])
    with pytest.raises(BadFile, match=r"longer: it cannot be compared with .*: the budget of steps .* is 5, not 20"):
        compare_studies([labs[0], longer])


def test_two_prompts_of_one_study_are_compared_like_two_agents(tmp_path):
    file = tmp_path / "curt.txt"
    file.write_text("{joints} {target} {reply}")
    conditions = (read_condition("truth"), read_condition(f"prompt?file={file}"))
    prompted = write_study(tmp_path / "prompted", replace(A, agents=("random",), conditions=conditions))
    usual = write_study(tmp_path / "usual", replace(A, agents=("random",), conditions=conditions[:1]))
    found = compare_studies([prompted, usual])
    assert [(row.condition, row.side.study, row.side.prompt) for row in found.success] == [
        ("truth", 0, ""),
        ("truth", 0, str(file)),
        ("truth", 1, ""),
    ]
    assert sorted(one.kind for one in found.differences) == ["between", "between", "within"]
    assert found.names[found.success[1].side] == f"random with {file} in prompted"


def test_every_condition_that_two_studies_share_is_compared_and_what_one_has_is_named(tmp_path):
    """Studies without a flip, with other names for the same conditions and in another order."""
    flipless = replace(A, agents=("cognitive:careful",), repetitions=1, trials=3)

    def lab(name, *conditions):
        return write_study(tmp_path / name, replace(flipless, conditions=tuple(conditions)))

    doses = [read_condition(f"tremble?p={p}") for p in (0.1, 0.2)]
    one = lab("a", read_condition("truth"), read_condition("drop?p=0.3", "mute"), *doses, read_condition("nudge", "x"))
    two = lab("b", *doses, read_condition("drop?p=0.3", "x"), read_condition("warn", "mute"), read_condition("truth"))
    found = compare_studies([one, two])
    assert [(row.condition, row.side.study) for row in found.success] == [
        (name, study) for name in ("truth", "tremble?p=0.1", "tremble?p=0.2", "drop?p=0.3") for study in (0, 1)
    ]
    assert [(one.condition, one.family) for one in found.differences] == [
        ("truth", "flip rate"),
        ("tremble?p=0.1", "tremble p"),
        ("tremble?p=0.2", "tremble p"),
        ("drop?p=0.3", ""),
    ]
    assert all((one.paired, one.value, one.p_value) == (True, 0, 1) for one in found.differences)  # one seed
    assert [one.not_shared for one in found.studies] == [("nudge",), ("warn",)]
    assert found.plain()["differences"][1]["family"] == "tremble p"
