"""Plans, the names by which joints go in a trial, and its luck, which has addresses."""

from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st
from seen import PhotographedPlant

from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import flips
from lockprobe.trial.luck import Luck, numbers
from lockprobe.trial.plan import Fork, Plan
from lockprobe.trial.record import ForkName

PLAN = Plan(
    study="test", agent="fake", box=box("chain-5"), condition=flips((0.0,), modalities=("rgb",))[0],
    repetition=1, trial=3, seed=1,
)  # fmt: skip


def test_names_agree_with_each_other_and_handles_have_the_order_of_the_listing():
    names = PLAN.names
    task = names.task
    assert sorted(names.order) == list(range(5))
    assert names.order != tuple(range(5))
    assert task.joints == names.listing == tuple(names.labels[i] for i in names.order)
    assert task.target == names.labels[PLAN.box.target_index]
    assert task.places == tuple(PLAN.box.joints[i].place for i in names.order)
    attempted = PhotographedPlant(PLAN.box).attempt(2)
    percept = names.percept(attempted)
    assert [int(x) for x in names.picture(attempted).handles[:, 0, 0]] == list(names.order)
    assert percept.joint == names.labels[2]
    assert names.percept(PhotographedPlant(PLAN.box).observe()).joint is None


def test_the_key_of_a_fork_is_that_of_its_parent_and_what_was_changed():
    name = ForkName(parent=PLAN.key, at=2, arm="lie", truthful=True, time=3)
    fork = Fork(name=name, condition=PLAN.label, acting=(), recorded=())
    forked = replace(PLAN, fork=fork, condition=replace(PLAN.condition, name="fork: lie"))
    assert forked.key == "test/fake/rgb/rep=1/trial=3/at=2/lie/then=truth/time=3"
    assert (forked.name, forked.label) == (PLAN.name, PLAN.label)


whole = st.integers(1, 10**6)


def luck(seed=1, box="chain-4", repetition=1, trial=1, time=1):
    return Luck(seed=seed, box=box, repetition=repetition, trial=trial, time=time)


def test_every_part_of_an_address_matters_and_it_suffices():
    lucks = [luck(), luck(seed=2), luck(box="fork"), luck(repetition=2), luck(trial=2), luck(time=2)]
    places = [(one, name, step) for one in lucks for name in ("agent", "channel-0") for step in (0, 1, 2)]
    drawn = {(one, name, step): tuple(one.at(name, step).random(6)) for one, name, step in [*places, *places]}
    assert len({number for numbers in drawn.values() for number in numbers}) == 6 * len(places)


def test_numbers_are_pinned():
    """Records of a release must be reproducible: these numbers must not be changed."""
    assert luck().at("labels").random(2).tolist() == PINNED


PINNED = [0.44539151655108744, 0.7928242151023083]


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
