"""What a receiver gets is what the file holds; one that refuses is named in one line."""

import json
from http.server import BaseHTTPRequestHandler, HTTPServer
from threading import Thread

import pytest
from builders import SOLUTION, make_trial

from lockprobe.errors import BadValue, Missing
from lockprobe.export.send_traces import endpoint_of, send_traces
from lockprobe.export.traces import requests


@pytest.fixture
def receiver():
    got = []

    class Receiver(BaseHTTPRequestHandler):
        def do_POST(self):
            body = self.rfile.read(int(self.headers["Content-Length"]))
            got.append((self.path, self.headers["Content-Type"], json.loads(body)))
            self.send_response(415 if self.path == "/no-json" else 200)
            self.end_headers()

        def log_message(self, *arguments):
            pass

    server = HTTPServer(("127.0.0.1", 0), Receiver)
    Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}", got
    server.shutdown()
    server.server_close()


def test_what_arrives_is_what_the_file_holds(receiver):
    url, got = receiver
    made = list(requests([make_trial(SOLUTION, trial=n) for n in range(1, 52)], "study"))
    assert send_traces(made, url) == len(made) == 2
    assert got == [("/v1/traces", "application/json", request) for request in made]


def test_a_receiver_without_json_is_named_in_one_line(receiver):
    url, _ = receiver
    with pytest.raises(Missing, match="status 415.*Collector"):
        send_traces(requests([make_trial(SOLUTION)], "study"), f"{url}/no-json")


@pytest.mark.parametrize(
    "url", ["", "localhost:4318", "file:///etc/passwd", "http://", "http://x:99999/", "http://a b"]
)
def test_only_http_is_spoken(url):
    with pytest.raises(BadValue, match="--endpoint"):
        endpoint_of(url)
