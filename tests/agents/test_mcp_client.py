"""The specs of agents that connect, and what knows them."""

import pytest

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.mcp_client import check_client, client_spec
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import group_of


@pytest.mark.parametrize("name", ["a", "claude-code", "gpt_5.1", "A" * 64])
def test_a_client_is_an_agent_that_no_run_plays_and_that_stands_alone(name):
    spec = client_spec(name)
    found = resolve(spec)
    assert (found.spec, found.engine, found.senses) == (spec, "client", "pictures")
    assert group_of(spec) == spec


@pytest.mark.parametrize("name", ["", "-a", "a b", "a/b", "a?b=1", "é", "A" * 65, "a\n", "a:b"])
def test_a_name_has_letters_digits_and_signs(name):
    with pytest.raises(BadValue, match="mcp:NAME"):
        client_spec(name)


@pytest.mark.parametrize("spec", ["mcp", "mcp:", "claude", "mcp:a:b"])
def test_other_specs_name_no_client(spec):
    with pytest.raises(BadValue, match="mcp:NAME"):
        check_client(spec)
