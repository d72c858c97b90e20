"""The seed matters, and it suffices."""

from lockprobe.foundation.seeds import generator


def test_every_part_of_the_path_matters():
    places = [(1, "a", 2), (2, "a", 2), (1, "b", 2), (1, "a", 3), (1, "a"), (1, "a2"), (1, "a", "2", "x")]
    assert len({generator(*place).random() for place in [*places, *places]}) == len(places)
