"""Where interventions act is worked out once, and what the record of every trial says of them."""

from dataclasses import dataclass

import pytest

from lockprobe import run_trial
from lockprobe.interventions.catalogue import interventions_of, with_words
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.trial.places import Places


@dataclass(frozen=True, kw_only=True)
class Aloud:
    """Acts on words."""

    after_words = True

    def perceive(self, percept, past, task, rng):
        return percept


def places(spec, *more):
    return Places.of(with_words((*interventions_of(spec), *more), TextChannel(tell="state")))


def test_every_intervention_has_its_place():
    found = places("nudge + flip?p=0.2 + tremble?p=0.1 + history?last=3 + drop?p=0.1", Aloud())
    names = [type(one).__name__ for one in found.all]
    of = {
        place: [names[number] for number in getattr(found, place)]
        for place in ("channels", "showing", "after", "prompts", "memories", "actuators")
    }
    assert of == {
        "channels": ["OutcomeFlip", "Drop"],
        "showing": ["TextChannel"],
        "after": ["Aloud"],
        "prompts": ["Nudge"],
        "memories": ["History"],
        "actuators": ["Tremble"],
    }


def test_without_words_all_channels_act_on_facts():
    found = Places.of(interventions_of("flip?p=0.2 + drop?p=0.1"))
    assert (found.channels, found.showing, found.after) == ((0, 1), (), ())


def test_streams_are_named_after_kind_and_number_and_may_lie_ahead():
    found = places("flip?p=0.2 + tremble?p=0.1 + flip?p=0.1 + yoked?p=0.4")
    assert found.streams == (
        ("channel-0", 0),
        ("Tremble-0", 0),
        ("channel-1", 0),
        ("channel-0", 1),
        None,
    )


def test_specs_are_numbered_where_they_are_equal_and_words_have_none():
    assert places("flip?p=0.2 + flip?p=0.2").specs == {0: "flip?p=0.2", 1: "flip?p=0.2 (2)"}


@pytest.mark.parametrize("spec", ["truth", "flip?p=0.3 + nudge", "tremble?p=0.2 + history?last=2"])
def test_the_record_says_what_acted(spec):
    trial, found = run_trial(agent="random", condition=spec, modality="symbolic?tell=state"), places(spec)
    assert (trial.channels, trial.interventions) == (found.channel_facts, found.other_facts)
    assert list(trial.changed) == list(found.specs.values())


def test_equal_settings_are_recorded_as_they_were_given():
    whole, real = (Places.of([OutcomeFlip(p=p)]).channel_facts[0]["p"] for p in (0, 0.0))
    assert (repr(whole), repr(real)) == ("0", "0.0")
