"""The contract of an intervention names what no report shows."""

from dataclasses import dataclass, replace

import pytest

from lockprobe.interventions.catalogue import interventions_of
from lockprobe.testing import check_intervention


@dataclass(frozen=True, kw_only=True)
class OutcomeAlone:
    """Says that everything moves, and leaves positions as they are."""

    def perceive(self, percept, past, task, rng):
        return percept if percept.joint is None else replace(percept, outcome="moved")


@dataclass(frozen=True, kw_only=True)
class TextBefore:
    """Says something before the words are made."""

    def perceive(self, percept, past, task, rng):
        return replace(percept, text="Well.")


@dataclass(frozen=True, kw_only=True)
class TextAfter(TextBefore):
    """Says something after the words are made."""

    after_words = True


@pytest.mark.parametrize(("one", "field"), [(OutcomeAlone(), "outcome"), (TextBefore(), "text")])
def test_what_no_report_shows_breaks_it(one, field):
    said = (
        f"{type(one).__name__} changes {field}, and no report in symbolic.tell=state shows that: .* shows joint and pos"
    )
    with pytest.raises(AssertionError, match=said):
        check_intervention(one)


def test_what_a_report_shows_keeps_it():
    check_intervention(OutcomeAlone(), modality="symbolic")
    check_intervention(TextAfter())


@dataclass(frozen=True, kw_only=True)
class Unreliable:
    """Declares that it leaves no report out, and does."""

    always_tells = True

    def perceive(self, percept, past, task, rng):
        return percept if percept.joint is None else replace(percept, joint=None, outcome=None, positions=None)


def test_what_leaves_a_report_out_must_not_declare_that_it_always_tells():
    with pytest.raises(AssertionError, match="Unreliable leaves a report out: it must not have always_tells"):
        check_intervention(Unreliable())


@dataclass(frozen=True, kw_only=True)
class Secretive:
    """Declares that it draws nothing, and does."""

    draws = False

    def act(self, joint, past, task, rng):
        return joint if rng.random() < 2 else ""


def test_what_draws_must_not_declare_that_it_does_not():
    with pytest.raises(AssertionError, match="Secretive draws: it must not have draws = False"):
        check_intervention(Secretive())


@pytest.mark.parametrize("spec", ["flip?p=0", "flip?p=1&at=1000", "drop?p=0", "history?last=1000", "nudge?after=9"])
def test_one_that_has_nothing_to_do_keeps_it(spec):
    check_intervention(*interventions_of(spec))
