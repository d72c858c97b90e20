"""What a receiver gets is what the file holds; one that refuses is named in one line."""

import json
import sys
from http.server import BaseHTTPRequestHandler, HTTPServer
from threading import Thread

import pytest
from builders import SOLUTION, make_trial

from lockprobe.foundation.errors import BadValue, Missing
from lockprobe.interfaces.export.send_traces import endpoints_of, send_traces
from lockprobe.interfaces.export.traces import requests


@pytest.fixture
def receiver():
    got = []

    class Receiver(BaseHTTPRequestHandler):
        def do_POST(self):
            body = self.rfile.read(int(self.headers["Content-Length"]))
            got.append((self.path, self.headers, body))
            self.send_response(
                {
                    "/no-json": 415,
                    "/base": 404,
                    "/locked": 403,
                    "/none": 404,
                    "/none/v1/traces": 404,
                    "/moved": 302,
                }.get(self.path, 200)
            )
            if self.path == "/moved":
                self.send_header("Location", "/page")
            if self.path == "/page":
                self.send_header("Content-Type", "text/html; charset=utf-8")
            self.end_headers()
            if self.path == "/partly/v1/traces":
                self.wfile.write(b'{"partialSuccess": {"rejectedSpans": "3", "errorMessage": "too old"}}')
            elif self.path != "/page":
                self.wfile.write(b'{"partialSuccess": {}}')

        def do_GET(self):
            self.send_response(200)
            self.end_headers()

        def log_message(self, *arguments):
            pass

    server = HTTPServer(("127.0.0.1", 0), Receiver)
    Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}", got
    server.shutdown()
    server.server_close()


@pytest.fixture
def without_protobuf(monkeypatch):
    monkeypatch.setitem(sys.modules, "google.protobuf.json_format", None)


def test_what_arrives_is_what_the_file_holds(receiver, without_protobuf):
    url, got = receiver
    made = list(requests([make_trial(SOLUTION, trial=n) for n in range(1, 52)], "study"))
    assert send_traces(made, url) == len(made) == 2
    assert [(path, headers["Content-Type"]) for path, headers, _ in got] == [("/v1/traces", "application/json")] * 2
    assert [json.loads(body) for _, _, body in got] == made


def test_as_protobuf_the_same_arrives(receiver):
    service = pytest.importorskip("opentelemetry.proto.collector.trace.v1.trace_service_pb2")
    url, got = receiver
    (request,) = requests([make_trial(SOLUTION)], "study")
    assert send_traces([request], url) == 1
    ((_, headers, body),) = got
    assert headers["Content-Type"] == "application/x-protobuf"
    found = service.ExportTraceServiceRequest.FromString(body).resource_spans[0].scope_spans[0].spans
    sent = request["resourceSpans"][0]["scopeSpans"][0]["spans"]
    assert [(span.trace_id.hex(), span.span_id.hex(), span.name, span.start_time_unix_nano) for span in found] == [
        (span["traceId"], span["spanId"], span["name"], int(span["startTimeUnixNano"])) for span in sent
    ]


def test_headers_for_a_receiver_are_those_of_the_environment(receiver, monkeypatch):
    url, got = receiver
    monkeypatch.setenv("OTEL_EXPORTER_OTLP_HEADERS", "Authorization=Basic%20abc=, x-project = 7")
    send_traces(requests([make_trial(SOLUTION)], "study"), url)
    assert (got[0][1]["Authorization"], got[0][1]["x-project"]) == ("Basic abc=", "7")


@pytest.mark.parametrize("headers", ["sk-private", "a b=sk-private", "k=sk-private%0d%0aHost: x", "k=sk-private,x"])
def test_headers_that_are_none_are_refused_and_never_shown(receiver, monkeypatch, headers):
    monkeypatch.setenv("OTEL_EXPORTER_OTLP_HEADERS", headers)
    with pytest.raises(BadValue, match="NAME=VALUE,NAME=VALUE") as refused:
        send_traces(requests([make_trial(SOLUTION)], "study"), receiver[0])
    assert "sk-private" not in str(refused.value)


def test_a_receiver_without_json_is_named_in_one_line(receiver, without_protobuf):
    url, _ = receiver
    with pytest.raises(Missing, match=r"status 415.*lockprobe\[otel\]"):
        send_traces(requests([make_trial(SOLUTION)], "study"), f"{url}/no-json")


@pytest.mark.parametrize(
    "url", ["", "localhost:4318", "file:///etc/passwd", "http://", "http://x:99999/", "http://a b"]
)
def test_only_http_is_spoken(url):
    with pytest.raises(BadValue, match="--endpoint"):
        endpoints_of(url)


@pytest.mark.parametrize("base", ["/base", "/page", "/moved", "/locked"])
def test_a_base_path_is_tried_with_the_path_of_traces(receiver, base):
    url, got = receiver
    made = list(requests([make_trial(SOLUTION, trial=n) for n in range(1, 52)], "study"))
    assert send_traces(made, url + base) == 2
    assert [path for path, _, _ in got] == [base, f"{base}/v1/traces", f"{base}/v1/traces"]


def test_a_path_of_its_own_is_used_as_it_is(receiver):
    url, got = receiver
    made = list(requests([make_trial(SOLUTION)], "study"))
    for path in ("/own", "/own/v1/traces", "/v1/traces/"):
        assert send_traces(made, url + path) == 1
        assert got.pop()[0] == path
        assert got == []


def test_where_neither_takes_them_both_are_named(receiver):
    url, _ = receiver
    with pytest.raises(Missing) as refused:
        send_traces(requests([make_trial(SOLUTION)], "study"), f"{url}/none")
    said = str(refused.value)
    assert said.startswith(f"{url}/none and {url}/none/v1/traces took 0 requests, then failed (status 404)")


def test_the_version_alone_is_completed_and_not_doubled():
    assert endpoints_of("http://here/otel/v1") == ("http://here/otel/v1", "http://here/otel/v1/traces")


def test_spans_that_a_receiver_rejects_are_not_said_to_be_sent(receiver, without_protobuf):
    url, _ = receiver
    with pytest.raises(Missing, match=r"took 0 requests, then failed \(it rejected 3 spans: too old\)"):
        send_traces(requests([make_trial(SOLUTION)], "study"), f"{url}/partly/v1/traces")
