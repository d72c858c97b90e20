"""What classes of agents, plants and interventions may declare, and what holds if they do not."""

from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.interventions.yoked import Yoked
from lockprobe.trial.protocols import AgentTraits, InterventionTraits, PlantTraits


class Nothing:
    """Declares nothing."""


class Everything:
    """Declares by class attributes, and by a property."""

    doses = ("p",)
    after_words = always_tells = unseeded = attended = True

    def __init__(self, ahead):
        self._ahead = ahead

    @property
    def ahead(self):
        return self._ahead


def test_what_declares_nothing_has_the_defaults():
    for one in (Nothing, Nothing(), None):
        assert InterventionTraits.of(one) == InterventionTraits()
        assert (AgentTraits.of(one), PlantTraits.of(one)) == (AgentTraits(), PlantTraits())


def test_what_is_declared_is_read_from_class_and_object():
    traits = InterventionTraits(doses=("p",), after_words=True, always_tells=True, ahead=3)
    assert InterventionTraits.of(Everything(3)) == traits
    assert InterventionTraits.of(Everything).doses == ("p",)
    assert AgentTraits.of(Everything).unseeded
    assert PlantTraits.of(Everything).attended


def test_our_own_classes_declare_what_the_loop_needs():
    flip, yoked, words = (InterventionTraits.of(one) for one in (OutcomeFlip(), Yoked(), TextChannel(tell="state")))
    assert (flip.name, flip.doses, flip.stream, flip.ahead) == ("flip", ("p", "keep"), "channel", 0)
    assert (yoked.stream, yoked.ahead) == (flip.stream, 1)
    assert words.shows
    assert words.shown is not None
    assert not words.after_words
