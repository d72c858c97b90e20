"""A picture as a file."""

from lockprobe.trial.pictures.picture import Picture


def test_equal_names_are_equal_pictures():
    one, same, other = (Picture(kind="rgb", png=png) for png in (b"a", b"a", b"b"))
    assert one.name == same.name != other.name
    assert one.name.endswith(".png")
    assert b"a" not in repr(one).encode().split(b"kind")[0]
