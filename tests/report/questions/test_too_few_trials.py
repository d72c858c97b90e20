"""A study that is stopped early says first how many trials its agents have, and then what its baselines did."""

import pytest
from builders import SOLUTION, make_trial, study_of, write_study

from lockprobe.boxes.families import box
from lockprobe.report.opened import open_study
from lockprobe.report.questions.too_few_trials import lacking_agents, unfinished_agents
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers

MODEL, BASELINE = "llm:acme/m", "human-inspired"
UNSOLVED = (0,) * 20


def numbers_of(directory, trials, agents=(MODEL, BASELINE), until=10):
    planned = study_of(name="flips", agents=agents, box=box("chain-4"), repetitions=1, trials=until)
    return study_numbers(open_study(write_study(directory / "study", planned, trials)))


def played(agent, *, solved, n=10, rates=(0, 0.4)):
    """Trials under each flip rate, of which so many are solved."""
    return [
        make_trial(SOLUTION if i < solved[p] else UNSOLVED, agent=agent, p=p, trial=i + 1)
        for p in rates
        for i in range(n)
    ]


AFFECTED = played(BASELINE, solved={0: 10, 0.4: 0})


@pytest.mark.parametrize(
    ("trials", "said"),
    [
        (
            [],
            (
                "Too few trials for an answer: llm:acme/m has finished none of 20 trials. Baselines: False reports lower the "
                "success of human-inspired (100 % to 0 % at a flip rate of 0.4)."
            ),
        ),
        (
            played(MODEL, solved={0: 1}, n=1, rates=(0,)),
            (
                "Too few trials for an answer: llm:acme/m has finished 1 of 20 trials. False reports lower the success of "
                "the baseline human-inspired (100 % to 0 % at a flip rate of 0.4)."
            ),
        ),
        (
            played(MODEL, solved={0: 2, 0.4: 1}, n=3),
            (
                "llm:acme/m has finished 6 of 20 trials. Inconclusive: no effect of false reports on the success of "
                "llm:acme/m was detected, and changes of up to 94 points are not excluded. False reports lower the success "
                "of the baseline human-inspired (100 % to 0 % at a flip rate of 0.4)."
            ),
        ),
    ],
)
def test_the_agent_under_study_comes_before_its_baselines(tmp_path, trials, said):
    assert results_of(numbers_of(tmp_path, [*trials, *AFFECTED])).answer == said


def test_a_finished_study_lacks_nothing(tmp_path):
    numbers = numbers_of(tmp_path, [*played(MODEL, solved={0: 2, 0.4: 1}), *AFFECTED])
    assert unfinished_agents(numbers) == lacking_agents(numbers) == {}
    assert results_of(numbers).answer.startswith("Inconclusive: no effect of false reports on the success of llm")


def test_an_answer_for_one_agent_comes_before_the_agents_that_are_still_to_come(tmp_path):
    numbers = numbers_of(tmp_path, played(MODEL, solved={0: 10, 0.4: 0}), agents=(MODEL, "cognitive:careful"))
    answer = results_of(numbers).answer
    assert answer.startswith(f"False reports lower the success of {MODEL}")
    assert answer.endswith("Still to come: cognitive:careful has finished none of 20 trials.")
