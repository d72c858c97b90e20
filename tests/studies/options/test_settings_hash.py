"""Equal settings have equal hashes, in whatever order their agents and conditions stand, and no others."""

from lockprobe.studies.options.settings_hash import hash_of, in_no_order


def test_the_order_of_agents_and_conditions_is_no_setting_and_any_other_order_is():
    one = {"agents": ["a", "b"], "conditions": [{"name": "x"}, {"name": "y"}], "box": [1, 2]}
    other = {"conditions": [{"name": "y"}, {"name": "x"}], "box": [1, 2], "agents": ["b", "a"]}
    assert hash_of(in_no_order(one)) == hash_of(in_no_order(other)) != hash_of(in_no_order(one | {"box": [2, 1]}))
    assert hash_of(in_no_order(one)) != hash_of(in_no_order(one | {"agents": ["a"]}))
    assert one["agents"] == ["a", "b"]


def test_whole_numbers_are_equal_however_they_are_written():
    assert hash_of({"p": 1.0, "q": [2.0]}) == hash_of({"q": [2], "p": 1}) != hash_of({"p": 1.5, "q": [2]})
