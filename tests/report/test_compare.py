"""Studies side by side: the numbers are those of the records, the conclusion says no more, and the page is inert."""

import re
from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, play_study, small_study, write_study

from lockprobe.foundation.errors import BadFile, UnknownName
from lockprobe.interventions.conditions import read_condition
from lockprobe.report.compare import (
    compare_studies,
    conclusion,
    difference_table,
    study_table,
    success_table,
    write_comparison,
)
from lockprobe.report.prose.subject import Subject
from lockprobe.statistics.agent_comparison.across_studies import Sample, Side, study_differences
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
    assert {(condition, *side[:2]): share for side, condition, share in found.success} == {
        key: proportion(sum(solved), len(solved)) for key, solved in counted.items()
    }
    assert [condition for _, condition, _ in found.success[:2]] == ["truth", "truth"]


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
    assert {side.agent for side, _, _ in chosen.success} == {"random"}
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
    assert [(condition, side.study, side.prompt) for side, condition, _ in found.success] == [
        ("truth", 0, ""),
        ("truth", 0, str(file)),
        ("truth", 1, ""),
    ]
    assert sorted(one.kind for one in found.differences) == ["between", "between", "within"]
    assert found.subjects[found.success[1][0]].name == f"random with {file} in prompted"


def test_every_condition_that_two_studies_share_is_compared_and_what_one_has_is_named(tmp_path):
    """Studies without a flip, with other names for the same conditions and in another order."""
    flipless = replace(A, agents=("cognitive:careful",), repetitions=1, trials=3)

    def lab(name, *conditions):
        return write_study(tmp_path / name, replace(flipless, conditions=tuple(conditions)))

    doses = [read_condition(f"tremble?p={p}") for p in (0.1, 0.2)]
    one = lab("a", read_condition("truth"), read_condition("drop?p=0.3", "mute"), *doses, read_condition("nudge", "x"))
    two = lab("b", *doses, read_condition("drop?p=0.3", "x"), read_condition("warn", "mute"), read_condition("truth"))
    found = compare_studies([one, two])
    assert [(condition, side.study) for side, condition, _ in found.success] == [
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


# The conclusion


def sample(study, solved, *, luck=1, agent="llm:a", condition="truth", broken=0, baseline=False):
    trials = [make_trial(SOLUTION if i < solved else (0,) * 20, agent=agent, trial=i + 1) for i in range(20)]
    trials += [make_trial([0], agent=agent, trial=21 + i, broken="model") for i in range(broken)]
    return Sample(side=Side(study, agent), condition=condition, luck=luck, baseline=baseline, trials=trials)


def studies_said(*samples):
    found = study_differences(samples)
    names = {
        one.side: Subject(name=f"{one.side.agent} in {'abc'[one.side.study]}", plural=one.side.agent == "people")
        for one in samples
    }
    return conclusion(found, names)


def test_a_difference_that_is_not_shown_is_not_said_to_be_nothing():
    found = studies_said(sample(0, 9), sample(1, 11, luck=2))
    assert found.startswith(
        "No difference between studies was detected, which does not show that there is none; it is "
    )
    assert "solves" not in found
    several = studies_said(sample(0, 9), sample(1, 11, luck=2), sample(2, 10, luck=3))
    assert several.startswith("No difference between studies was detected in 3 comparisons, ")
    assert "P = 1, corrected for 3 differences" in several


def test_a_sentence_about_several_families_is_corrected_for_their_number():
    """A P value of 0.03 in its family: the sentence is about two, and the table about each."""
    nudged = [replace(sample(study, n, condition="nudge", luck=study), family="") for study, n in ((0, 4), (1, 11))]
    flips = [replace(sample(study, 10, luck=study), family="flip rate") for study in (0, 1)]
    alone, both = studies_said(*nudged), studies_said(*flips, *nudged)
    assert alone.startswith("llm:a in b solves the box more often than llm:a in a under nudge: ")
    assert both.startswith("No difference between studies was detected in 2 comparisons, ")
    assert ", corrected for 1 difference of its family and for 2 families of conditions; " in both
    assert both.endswith(" 1 more is detected if each family is taken alone.")
    clear = [replace(sample(study, n, condition="nudge"), family="") for study, n in ((0, 1), (1, 19))]
    assert studies_said(*flips, *clear).startswith(
        "1 of 2 differences between studies was detected: llm:a in b solves "
    )
    assert "taken alone" not in studies_said(*flips, *clear)


# The page

STUDY = small_study(agents=("cognitive:careful", "random"), p=(0.0, 0.3))
ATTACK = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    root = tmp_path_factory.mktemp("compared")
    other = replace(STUDY, agents=("cognitive:perseverant",), seed=3)
    first, second = write_study(root / "a", STUDY), write_study(root / "b", other, play_study(other)[:10])
    found = compare_studies([first, second])
    return found, write_comparison(found, root / "compare.html").read_text("utf-8")


def test_the_page_begins_with_the_sentence_and_holds_every_number(compared):
    found, page = compared
    text = re.sub(r"\s+", " ", re.sub(r"<[^>]*>", "", page))
    assert text.index(found.said) < text.index("Difference in success")
    assert "10 of 16 trials of b" in text
    tables = (success_table(found), study_table(found), difference_table(found, found.differences))
    for cell in {cell for table in tables for row in table for cell in row}:
        assert cell in text
    assert page.count("<figure") == 1
    assert "more differences: with baselines, and within one study" in text


def test_it_runs_nothing_and_loads_nothing(compared):
    _, page = compared
    assert "default-src 'none'; img-src data:; style-src 'unsafe-inline'\"" in page
    assert "<script" not in page
    sources = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert sources
    assert all(source.startswith("data:image/svg+xml,") for source in sources)


def test_what_agents_and_directories_are_called_is_text(tmp_path):
    study = small_study(agents=("llm:a",), p=(0.0,), repetitions=1, trials=2)
    played = play_study(replace(study, agents=("random",)))
    labs = []
    for seed, name in enumerate(("<img src=x onerror=alert(1)>", "b")):
        facts = {"<b>model</b>": f"{ATTACK}{seed}"}
        trials = [replace(t, agent="llm:a", key=t.key.replace("random", "llm:a"), facts=facts) for t in played]
        labs.append(write_study(tmp_path / name, study, trials))
    found = compare_studies(labs)
    page = write_comparison(found, tmp_path / "compare.html").read_text("utf-8")
    assert ATTACK in found.unlike[0]
    assert "<img src=x" in found.said
    assert not re.search("<script|<img src=x|<b>", page)


def test_two_studies_without_a_trial_are_said_to_have_none(tmp_path):
    labs = [write_study(tmp_path / name, STUDY, []) for name in "ab"]
    page = write_comparison(compare_studies(labs), tmp_path / "compare.html").read_text("utf-8")
    assert "No two agents have a trial to compare." in page
    assert "<figure" not in page


def test_a_page_that_cannot_be_written_is_a_mistake_in_one_line(compared, tmp_path):
    with pytest.raises(BadFile, match="cannot be written"):
        write_comparison(compared[0], tmp_path / "none" / "compare.html")


@pytest.mark.parametrize(("name", "section"), [("_picture", "Figure differences"), ("study_table", "Table studies")])
def test_no_figure_or_table_keeps_the_page_from_being_written(monkeypatch, compared, tmp_path, name, section):
    def broken(*_):
        raise RuntimeError("broken on purpose")

    monkeypatch.setattr(f"lockprobe.report.compare.{name}", broken)
    told = []
    page = write_comparison(compared[0], tmp_path / "compare.html", left_out=told.append).read_text("utf-8")
    assert [one.section for one in told] == [section]
    assert f"{section} (RuntimeError: broken on purpose)" in page
