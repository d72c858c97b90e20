"""How many trials the agents of an unfinished study have, in words."""

from lockprobe.report.prose.too_few_trials import finished_said, of_baselines, too_few_said


def test_it_is_said_how_many_trials_of_how_many_are_finished():
    assert finished_said({}) == too_few_said({}) == ""
    assert finished_said({"a": (8, 24)}) == "a has finished 8 of 24 trials."
    assert too_few_said({"a": (0, 24)}) == "Too few trials for an answer: a has finished none of 24 trials."
    many = dict.fromkeys("abcde", (1, 9))
    assert finished_said(many) == "a has finished 1 of 9 trials, b 1 of 9 and 3 others."


def test_an_answer_about_baselines_alone_is_marked():
    assert of_baselines("") == ""
    assert of_baselines("Nothing changed.") == "Baselines: Nothing changed."
