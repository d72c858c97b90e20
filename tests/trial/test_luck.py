"""Luck has addresses: every part of one matters, nothing else does, and one trial draws what many draw at once."""

from hypothesis import given
from hypothesis import strategies as st

from lockprobe.trial.luck import Luck, at_step, numbers

whole = st.integers(1, 10**6)


def luck(seed=1, box="chain-4", repetition=1, trial=1, time=1):
    return Luck(seed=seed, box=box, repetition=repetition, trial=trial, time=time)


def test_every_part_of_an_address_matters_and_it_suffices():
    lucks = [luck(), luck(seed=2), luck(box="fork"), luck(repetition=2), luck(trial=2), luck(time=2)]
    places = [(one, name, step) for one in lucks for name in ("agent", "channel-0") for step in (0, 1, 2)]
    drawn = {(one, name, step): tuple(one.at(name, step).random(6)) for one, name, step in [*places, *places]}
    assert len({number for numbers in drawn.values() for number in numbers}) == 6 * len(places)
    assert luck().stream("agent", ahead=3).at(5).random() == luck(trial=4).at("agent", 5).random()


def test_numbers_are_pinned():
    """Records of a release must be reproducible: these numbers must not be changed."""
    assert luck().at("labels").random(2).tolist() == PINNED


PINNED = [0.44539151655108744, 0.7928242151023083]


@given(whole, whole, st.lists(st.integers(1, 40), min_size=1, max_size=20))
def test_a_stream_begins_anew_at_every_step(repetition, trial, steps):
    stream = luck(repetition=repetition, trial=trial).stream("agent")
    for step in steps:
        alone = luck(repetition=repetition, trial=trial).at("agent", step)
        rng = stream.at(step)
        assert at_step(rng, 7).random() == luck(repetition=repetition, trial=trial).at("agent", 7).random()
        assert rng.permutation(5).tolist() == alone.permutation(5).tolist()
        assert rng.random(step).tolist() == alone.random(step).tolist()


@given(
    st.lists(st.tuples(st.integers(0, 2**70), whole, whole, st.integers(0, 10_000)), min_size=1, max_size=9),
    st.integers(1, 17),
    st.sampled_from(["agent", "channel-0"]),
)
def test_many_trials_draw_at_once_what_each_draws_alone(addresses, places, name):
    seed, repetition, trial, step = (list(column) for column in zip(*addresses, strict=True))
    found = numbers("fork", name, seed=seed, repetition=repetition, trial=trial, step=step, places=places)
    for row, (own, repeated, of, at) in zip(found.tolist(), addresses, strict=True):
        assert row == luck(own, "fork", repeated, of).at(name, at).random(places).tolist()
