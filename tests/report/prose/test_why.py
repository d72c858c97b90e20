"""The sentence says what the verdict is, coarse first, with the numbers that it rests on."""

from dataclasses import replace

import pytest
from why_answers import answer, mean

from lockprobe.report.prose.why import mechanism_said, why_said


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (
            answer("says", "last"),
            (
                "raise the success of cognitive:insistent through what they say: of reports in two statements, those whose "
                "last statement is false raise it."
            ),
        ),
        (answer("says", "first", lie=10), "lower the success of cognitive:insistent through what they say: of reports"),
        (
            answer("says", "last", "first"),
            (
                "through what they say in several ways: of reports in two statements, those whose last statement is false "
                "raise it and those whose first statement is false raise it."
            ),
        ),
        (answer("says", "contradiction"), "a single false statement is enough to raise it."),
        (answer("says", "falsity"), "which of the two counts is not decided."),
        (
            answer("form", "form"),
            "as any odd report does: a true correction and an irrelevant remark raise it too, so falsity is not needed.",
        ),
        (
            answer("both", "last", "form"),
            (
                "both through what they say and as any odd report does: of reports in two statements, those whose last "
                "statement is false raise it; a true correction and an irrelevant remark raise it too."
            ),
        ),
        (answer("blurred"), "a true correction does it as well, so corrections cannot show why."),
        (answer("not decided"), "Whether through what they say or as any odd report does is not decided."),
        (answer("no change", lie=30), "change the success of cognitive:insistent by less than 10 points."),
        (answer("inconclusive", lie=30), "Inconclusive: no effect of false reports on the success of cognitive:insist"),
    ],
)
def test_every_verdict_has_its_sentence(found, said):
    assert said in mechanism_said(found)


@pytest.mark.parametrize("verdict", ["says", "form", "both", "blurred", "not decided", "no change", "inconclusive"])
def test_no_sentence_says_that_a_report_is_believed(verdict):
    claims = {"says": ("last",), "form": ("form",), "both": ("last", "form")}.get(verdict, ())
    said = " ".join(why_said(answer(verdict, *claims)))
    assert not any(word in said for word in ("believe", "because", "disturb"))


def test_the_numbers_follow_and_name_what_the_claim_rests_on():
    _, numbers, rests_on = why_said(answer("says", "last"))
    assert numbers == (
        "20 % of trials were solved with true reports, 40 % with reports inverted at a rate of 0.4: +20 points "
        "(95 % interval +15 to +25; P = 0.001). With reports in two statements it is 20 % if both are true, 20 % if the "
        "first is false, 20 % if the last is false and 20 % if both are."
    )
    assert rests_on == (
        "The claim rests on these differences: false last after true +20 points (95 % interval +15 to +25; P = 0.001); "
        "false last after false +20 points (95 % interval +15 to +25; P = 0.001)."
    )


def test_a_true_correction_that_does_it_too_is_named_where_the_verdict_leaves_it_out():
    said = "A true correction changes success in the same direction: +20 points (95 % interval +15 to +25; P = 0.001)."
    plain, too = answer("says", "last"), answer("both", "last", "form")
    assert too.decision.corrections_alone
    named = why_said(replace(too, decision=replace(too.decision, verdict="says", claims=("last",))))
    assert [one.startswith(said) for one in named] == [False, False, False, True]
    assert not any("A true correction" in one for one in (*why_said(plain), *why_said(too)[1:]))


@pytest.mark.parametrize("verdict", ["no change", "inconclusive"])
def test_where_no_effect_is_detected_nothing_is_said_of_the_arms(verdict):
    said = " ".join(why_said(answer(verdict, lie=30)))
    assert "two statements" not in said
    assert "false last" not in said
    assert "in either direction give P = 0.5" in said


def test_what_is_open_says_what_would_decide_it():
    assert why_said(answer("inconclusive", lie=30))[-1] == (
        "About 230 blocks are needed to detect a change of 10 points with a power of 80 %; this study has 150."
    )
    enough = replace(answer("inconclusive", lie=30), needed=140)
    assert not any("are needed" in said for said in why_said(enough))
    assert "lockprobe power why" in why_said(answer("not decided"))[-1]
    assert not any("lockprobe power why" in said for said in why_said(answer("blurred")))


def test_what_else_changes_success_is_named_without_a_mechanism():
    said = why_said(answer("form", "form", others=("withheld", "false outcome")))[3:]
    assert said[0].startswith("Other interventions at the same steps also raise success: withheld +20 points")
    assert said[1].startswith("Parts of a false report also raise success: false outcome +20 points")
    assert len(why_said(answer("form", "form", lie=10, others=("withheld",)))) == 3


def test_of_several_agents_it_says_for_how_many_its_numbers_are_corrected():
    said = "P values and intervals of differences are corrected for 10 agents (Bonferroni)."
    assert why_said(answer("says", "last", agents=10))[-1] == said
    assert not any("corrected for" in one for one in why_said(answer("says", "last")))


def test_what_only_an_uncorrected_interval_shows_is_not_named():
    found = answer("form", "form", others=("withheld",))
    *rest, last = found.arms
    unsure = replace(last, change=replace(last.change, p_value=0.2))
    assert last.change.clear
    assert len(why_said(replace(found, arms=(*rest, unsure)))) == 3


def test_where_one_false_statement_does_more_than_two_the_clause_says_so():
    found = answer("says", "falsity")
    contrasts = found.decision.contrasts | {"both false": mean(0.1)}
    more = replace(found, decision=replace(found.decision, contrasts=contrasts))
    assert mechanism_said(more).endswith("a single false statement is enough to raise it, and does more than two.")


def test_blocks_without_both_trials_are_said():
    found = answer("says", "last")
    fewer = replace(found, decision=replace(found.decision, total=replace(found.decision.total, blocks=140)))
    assert "140 of 150 blocks have both trials" in why_said(fewer)[1]
    assert "blocks have both" not in why_said(found)[1]
