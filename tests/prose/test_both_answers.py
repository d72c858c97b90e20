"""The first sentence of a page that answers two questions: a change stands if it is detected after both."""

from types import SimpleNamespace

import pytest

from lockprobe.prose import both_answers as module
from lockprobe.prose.both_answers import both_answers

LOST = "was detected in its own section (P = {}), but not after correction for both questions"


def answered(monkeypatch, flips, conditions):
    """The sentence for studies with these P values in their two families."""
    monkeypatch.setattr(module, "flips_answer", lambda summary: "Flips.")
    monkeypatch.setattr(module, "effects_answer", lambda found, other: "Conditions." if other else "")

    def one(p_value):
        return SimpleNamespace(difference=SimpleNamespace(p_value=p_value))

    subjects = [SimpleNamespace(contrast=one(p_value)) for p_value in flips] or [SimpleNamespace(contrast=None)]
    return both_answers(SimpleNamespace(subjects=subjects), [SimpleNamespace(effects=[*map(one, conditions)])])


@pytest.mark.parametrize(
    ("flips", "conditions", "lost"),
    [
        ([0.001], [0.8], {}),
        ([0.03], [0.8], {"flips": "0.03"}),  # Holm: 2 x 0.03
        ([0.03, 0.9], [0.02, 0.7], {}),  # 2 x 0.02, then 0.03
        ([0.03], [0.04], {"flips": "0.03", "conditions": "0.04"}),
        ([0.6], [0.026], {"conditions": "0.026"}),
        ([], [0.03], {}),  # one question alone
        ([0.5], [0.5], {}),
    ],
)
def test_a_change_is_said_if_it_is_detected_after_both(monkeypatch, flips, conditions, lost):
    said = answered(monkeypatch, flips, conditions)
    first = f"An effect of false reports {LOST.format(lost['flips'])} of this page." if "flips" in lost else "Flips."
    then = (
        f"An effect of other conditions {LOST.format(lost['conditions'])} of this page."
        if "conditions" in lost
        else "Conditions."
    )
    assert said == f"{first} {then}"
