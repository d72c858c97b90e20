"""Courses: which trials tests are of, and which agents are judged together."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, play_study, small_study

from lockprobe.statistics.course import courses, never_acted


def trials_of(agent, solved, n=6, modality="symbolic"):
    """Trials at each flip rate, of which so many are solved; others fail in another way at every rate."""
    return [
        make_trial(
            SOLUTION if i < solved[p] else (int(10 * p) % 4, *(0,) * 19),
            agent=agent,
            p=p,
            trial=i + 1,
            modality=modality,
        )
        for p in solved
        for i in range(n)
    ]


def family_of(*groups):
    return {one.agent: one.family for one in courses([trial for own in groups for trial in own])}


def test_agents_under_study_are_one_family_and_baselines_another():
    """Only those that heed what they are told and were played at two rates count."""
    two, one = {0.0: 2, 0.4: 4}, {0.0: 2}
    found = family_of(
        *(trials_of(f"llm:{name}", two) for name in "abc"),
        trials_of("llm:d", one),
        trials_of("human-inspired", two),
    )
    assert found == {"llm:a": 3, "llm:b": 3, "llm:c": 3, "llm:d": 3, "human-inspired": 1}


@pytest.mark.parametrize(
    ("spec", "baseline"),
    [
        ("human-inspired:proximity", True),
        ("human-inspired?lapse=0.1", True),
        ("ideal-observer?noise=aware", True),
        ("random", True),
        ("cognitive:careful", False),
        ("llm:local", False),
        ("participant", False),
    ],
)
def test_variants_of_a_baseline_are_baselines(spec, baseline):
    (found,) = courses(trials_of(spec, {0.0: 2}))
    assert found.baseline == baseline


def test_an_agent_that_ignores_reports_is_blind_and_tested_nowhere():
    found = {one.agent: one for one in courses(play_study(small_study()))}
    assert found["random"].blind
    assert {*found["random"].ended.dose.tolist()} == {0.0}
    assert not found["human-inspired"].blind
    assert {*found["human-inspired"].ended.dose.tolist()} == {0.0, 0.3, 0.6}


def test_a_rate_at_which_no_report_was_false_is_in_no_test():
    truthful = [
        replace(
            make_trial(SOLUTION, agent="llm:a", p=0.2, trial=i, modality="symbolic"),
            changed={"flip?p=0.2": 0},
            changed_steps=0,
        )
        for i in (1, 2)
    ]
    (found,) = courses([*trials_of("llm:a", {0.0: 1, 0.4: 3}), *truthful])
    assert never_acted(truthful)
    assert found.idle == {0.2}
    assert {*found.ended.dose.tolist()} == {0.0, 0.4}
    assert [*found.by_dose] == [0.0, 0.2, 0.4]


def test_a_model_shown_the_box_in_two_ways_has_a_course_for_each():
    found = courses([*trials_of("llm:a", {0.0: 2}, modality="rgb"), *trials_of("llm:a", {0.0: 2})])
    assert [(one.modality, bool(one.shown)) for one in found] == [("rgb", True), ("symbolic", True)]
