"""What a study that stops when it is decided is expected to play from where it stands."""

from builders import play_study

from lockprobe.studies.costs.expected_trials import ASSUMPTIONS, outlooks
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.stopping import at_most, families

EFFECT, NOTHING = ASSUMPTIONS


def planned(**more):
    return study("flips", **({"agent": "cognitive:perseverant", "p": [0, 0.6], "until": "decided", "most": 40} | more))


def test_every_condition_differs_from_its_control():
    two = planned(modality=["symbolic", "symbolic?tell=state"])
    success = EFFECT.success(families(two, two.agents[0]))
    assert set(success.values()) == {0.23, 0.67}
    for family in families(two, two.agents[0]):
        for one in family.questions:
            ((more, less),) = one.terms
            assert success[more] != success[less]
    why = study("why", agent="random", until="decided")
    success = EFFECT.success(families(why, "random"))
    assert [label for label, share in success.items() if share == 0.23] == ["truth"]
    assert len(success) == 7
    assert set(NOTHING.success(families(why, "random")).values()) == {0.23}


def test_trials_on_record_stay_and_the_rest_is_drawn():
    asked = planned()
    (agent,) = asked.agents
    fresh = outlooks(asked, agent, [])
    assert [one.assumption for one in fresh] == [EFFECT, NOTHING]
    assert 5 * fresh[1].decided < fresh[0].decided
    assert max(fresh[1].totals) <= 80 == len(at_most(asked, agent, []))
    trials = play_study(planned(until=None, most=None, trials=30, repetitions=1))
    assert at_most(asked, agent, trials) == []
    assert [set(one.totals) for one in outlooks(asked, agent, trials)] == [{0}, {0}]
    few = [one for one in trials if one.trial <= 5]
    for before, after in zip(fresh, outlooks(asked, agent, few), strict=True):
        assert max(after.totals) <= 70
        assert all(0 <= share <= 1 for share in after.shares.values())
        assert min(after.totals) <= min(before.totals)


def test_a_single_condition_has_no_effect_to_assume():
    alone = planned(p=[0])
    assert [one.assumption for one in outlooks(alone, alone.agents[0], [])] == [NOTHING]
