"""Questions with one right answer."""

import pytest

from lockprobe.people.experiment import Experiment
from lockprobe.people.right_answers import Comprehension, ComprehensionQuestion, missed

QUESTION = {"question": "When?", "options": ["now", "never"], "right": "now"}


def test_the_questions_that_were_answered_wrong_are_named():
    questions = [ComprehensionQuestion(**QUESTION | {"question": name}) for name in ("a", "b", "c")]
    assert missed(questions, ("now", "never", "now")) == ("b",)
    assert missed(questions, ("now",) * 3) == ()
    assert missed((), ()) == ()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"right": "then"}, "right must be one of them"),
        ({"options": ["now", "now"]}, "options must be distinct"),
        ({"options": ["now"]}, "at least 2"),
        ({"only": "sometimes"}, "positions"),
        ({"when": 1}, "when"),
    ],
)
def test_a_question_without_one_right_answer_is_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        ComprehensionQuestion(**QUESTION | wrong)


def test_they_are_asked_without_a_limit_unless_the_experimenter_says_otherwise():
    assert Experiment().comprehension == Comprehension(ask=True, rounds=None, questions=())
    with pytest.raises(ValueError, match="greater than or equal to 1"):
        Comprehension(rounds=0)
