"""Which studies can be compared: the same task, and a condition in common, whatever it is called."""

from dataclasses import replace
from pathlib import Path

import pytest
from builders import small_study, study_of, write_study

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, UserMistake
from lockprobe.interventions.conditions import read_condition
from lockprobe.report.compare import check_same_task, compare_studies, families, shared

FLIPS = small_study()
A, B = Path("a"), Path("b")


def of_conditions(*specs, **names):
    conditions = [read_condition(spec) for spec in specs]
    conditions += [read_condition(spec, name) for name, spec in names.items()]
    return replace(FLIPS, conditions=tuple(conditions))


SEVERAL = replace(FLIPS, boxes=(FLIPS.box, box("fork"), box("reset")))


@pytest.mark.parametrize(
    ("study", "change", "why"),
    [
        (SEVERAL, {"boxes": (FLIPS.box,)}, "box is chain-4, not chain-4, fork, reset"),
        (SEVERAL, {"seed": 9}, "seed is 9, not 1"),  # several boxes are compared in pairs of equal luck
        (FLIPS, {"boxes": (box("chain-5"),)}, "box is chain-5, not chain-4"),
        (FLIPS, {"boxes": (replace(box("chain-5"), name="chain-4"),)}, "box is chain-4, not another chain-4"),
        (FLIPS, {"max_steps": 30}, "max_steps is 30, not 20"),
        (FLIPS, {"plant": "fast-twin"}, "plant is fast-twin, not symbolic"),
        (FLIPS, {"layout": "shuffled"}, "layout is shuffled, not fixed"),
        (FLIPS, {"assessment": False}, "assessment is False, not True"),
    ],
)
def test_another_task_is_refused_with_the_reason(study, change, why):
    check_same_task({A: study, B: replace(study, agents=("round-robin",))})
    with pytest.raises(BadFile, match=rf"^b: it cannot be compared with a: {why}$"):
        check_same_task({A: study, B: replace(study, **change)})


def test_one_study_and_one_without_a_condition_in_common_are_refused_with_the_reason(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    flips = study_of((0.1, 0.9), name="flips", agents=("random",), boxes=(box("chain-4"),))
    sticky = study_of((0.3,), "integrated", name="flips", agents=("random",), boxes=(box("chain-4"),))
    for name, study in {"a": FLIPS, "b": flips, "c": sticky, "d": FLIPS}.items():
        write_study(tmp_path / name, study, [])
    for asked, said in (
        ("a", "two or more"),
        ("ab", r"^a: it shares no condition .*: it has truth, flip\?p=0\.3 and flip\?p=0\.6; they"),
        ("ac", r"they have flip\?p=0\.3&others=kept$"),
        ("adb", "^b: it shares no condition"),
    ):
        with pytest.raises(UserMistake, match=said):
            compare_studies([*map(Path, asked)])


def test_a_prompt_belongs_to_the_agent(tmp_path):
    file = tmp_path / "curt.txt"
    file.write_text("{joints} {target} {reply}")
    study = of_conditions("truth", f"prompt?file={file}", f"prompt?file={file} + nudge")
    found = [(acting.label, prompt) for acting, prompt in shared(study).values()]
    assert found == [("truth", ""), ("truth", str(file)), ("nudge", str(file))]


def test_families_are_flip_rates_with_the_truth_every_other_axis_and_all_others():
    study = of_conditions("tremble?p=0.1", "nudge", "truth", "flip?p=0.4", "tremble?p=0.2", "drop?p=0.3")
    found = " ".join(
        f"{name}:{family}" for name, family in families(acting for acting, _ in shared(study).values()).items()
    )
    doses = "tremble?p=0.1:tremble p tremble?p=0.2:tremble p"
    assert found == f"truth:flip rate flip?p=0.4:flip rate {doses} nudge: drop?p=0.3:"
