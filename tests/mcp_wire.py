"""A client of ``lockprobe mcp`` that writes its lines itself, so that it can be malformed, in a hurry, or gone."""

import json
import os
import subprocess

import forked

FIRST = "import lockprobe.cli.mcp, lockprobe.interfaces.mcp.stdio"
"""What takes seconds to import, and is the same for every server."""

HELLO = {
    "protocolVersion": "2025-06-18",
    "capabilities": {},
    "clientInfo": {"name": "wire", "version": "1"},
}


class Wire:
    """A server in a process of its own, and the pipes to it."""

    def __init__(self, *asked, cwd=None, hello=True):
        reads, writes = os.pipe()
        self.process = forked.start(
            ["mcp", *asked], first=FIRST, stdin=reads, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, cwd=cwd
        )
        os.close(reads)
        self._to = os.fdopen(writes, "wb", buffering=0)
        self._number = 0
        if hello:
            self.ask("initialize", HELLO)
            self.send({"jsonrpc": "2.0", "method": "notifications/initialized"})

    def send(self, message):
        """Write one line: an object, or bytes as they are."""
        line = message if isinstance(message, bytes) else json.dumps(message).encode()
        self._to.write(line + b"\n")

    def ask(self, method, params):
        """Ask, and wait for the answer to this question."""
        self.post(method, params)
        return self.answer(self._number)

    def post(self, method, params):
        """Ask, and do not wait."""
        self._number += 1
        self.send({"jsonrpc": "2.0", "id": self._number, "method": method, "params": params})
        return self._number

    def answer(self, number):
        """The answer to a question; EOFError if the server is gone."""
        while line := self.process.stdout.readline():
            found = json.loads(line)
            if found.get("id") == number:
                return found
        raise EOFError

    async def call(self, tool, given):
        """As :class:`tool_player.Player` calls a tool."""
        result = self.ask("tools/call", {"name": tool, "arguments": given})["result"]
        return None if result["isError"] else result["content"][0]["text"]

    def go(self):
        """Close the pipes, as a client that ends; the exit status of the server."""
        self._to.close()
        status = self.process.wait(60)
        self.process.stdout.close()
        return status
