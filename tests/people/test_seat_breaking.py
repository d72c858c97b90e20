"""A box that breaks is nobody's failure: it is owed again, and the participant goes on with the next one."""

import pytest
from seated import Player, diary_of, go_on, people_study, refused, sitting, to_first

from lockprobe.people.diary import Broken, Did
from lockprobe.people.responses import Attempt
from lockprobe.people.scenes import Box
from lockprobe.plants import catalogue
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.journal import load

STUDY = people_study(max_steps=5)


class _Fragile(SymbolicPlant):
    """Breaks at some of all attempts, and cannot be seen where it is dark."""

    attempts = 0
    breaks: tuple[int, ...] = ()
    dark = False

    def observe(self):
        if type(self).dark:
            raise OSError("no light")
        return super().observe()

    def attempt(self, joint):
        type(self).attempts += 1
        if type(self).attempts in type(self).breaks:
            raise OSError("stuck")
        return super().attempt(joint)


@pytest.fixture
def plant(monkeypatch):
    class Plant(_Fragile):
        pass

    source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: Plant(box))
    monkeypatch.setattr("lockprobe.studies.play.resolve_plant", lambda spec: source)
    return Plant


def test_a_box_that_breaks_is_no_failure_and_the_next_one_comes(tmp_path, plant):
    plant.breaks = (4,)  # one attempt is that of the example

    async def breaks(reception, shown):
        player = Player(tmp_path, STUDY, "round-robin")
        shown = await go_on(reception, player, shown, lambda one: one.scene.kind == "over")
        assert (shown.scene.number, shown.scene.solved) == (1, None)
        progress = reception.progress()
        assert (progress.participants[0].broken, sum(one.free for one in progress.conditions)) == (1, 7)
        return await go_on(reception, player, shown)

    shown = sitting(tmp_path, STUDY, breaks)
    first, second = load(tmp_path)
    assert (first.ending, first.error.boundary, len(first.steps), first.owed_again) == ("error", "plant", 2, True)
    assert second.ending in ("solved", "budget")
    ended = [line.ended for line in diary_of(tmp_path, shown.identity) if isinstance(line, Did) and line.ended]
    assert ended == ["error", second.ending]


def test_a_box_that_cannot_be_shown_is_passed_over(tmp_path, plant):
    async def dark(reception, shown):
        player = Player(tmp_path, STUDY, "round-robin")
        plant.dark = True
        shown = await go_on(reception, player, shown, lambda one: one.scene.kind == "over")
        plant.dark = False
        return await go_on(reception, player, shown)

    shown = sitting(tmp_path, STUDY, dark)
    assert [trial.ending == "error" for trial in load(tmp_path)] == [True, False]
    assert [(line.box, line.turn) for line in diary_of(tmp_path, shown.identity) if isinstance(line, Broken)] == [
        (1, 4)
    ]
    turns = [line.turn for line in diary_of(tmp_path, shown.identity)[1:]]
    assert turns == list(range(2, 2 + len(turns)))


def test_a_page_that_shows_a_box_which_broke_in_the_meantime_has_to_ask_anew(tmp_path, plant):
    async def broke(reception, shown):
        shown = await to_first(Box, reception, shown)
        for seat in reception._register:
            await seat.let_go()
        plant.dark = True
        act = Attempt(joint=shown.scene.panel.joints[0].label, rt=1.0)
        assert await refused(reception, shown, act) == "stale"
        return await reception.enter(shown.token, {})

    assert sitting(tmp_path, STUDY, broke).scene.kind == "over"
