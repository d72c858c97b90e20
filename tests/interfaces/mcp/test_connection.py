"""What a record says of the connection."""

import pytest

from lockprobe.agents.mcp_client import SAME_IN_ALL_TRIALS
from lockprobe.interfaces.mcp.connection import Connection, facts_of


def facts(**said):
    connection = Connection(**{"client": "name", "version": "1.2", "protocol": "2025-11-25", **said})
    return facts_of(connection, "0f", position=3, resumed=0)


def test_the_facts_say_how_the_agent_was_connected():
    assert facts() == {
        "protocol": "MCP tools 2025-11-25",
        "client": "name",
        "client_version": "1.2",
        "wording": "0f",
        "position": 3,
    }
    assert {*SAME_IN_ALL_TRIALS} <= {*facts()}
    resumed = facts_of(Connection(), "0f", position=1, resumed=2)
    assert (resumed["resumed"], resumed["client"], resumed["protocol"]) == (2, "", "MCP tools")


@pytest.mark.parametrize("name", ["a\nb", "x" * 10_000, "\u202ename", "sk-ant-0123456789abcdef"])
def test_what_a_client_says_of_itself_is_short_and_plain(name):
    client = facts(client=name)["client"]
    assert len(client) <= 100
    assert client.isprintable()
    assert "0123456789" not in client
