"""An OpenAI-compatible server on loopback whose answers a test decides."""

import base64
import json
import threading
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer


class Server:
    """Answers chat completions by a function of the request; keeps every request."""

    def __init__(self, answer):
        self.requests = []
        self.keys = []
        owner = self

        class Handler(BaseHTTPRequestHandler):
            def log_message(self, *args):
                pass

            def do_POST(self):
                request = json.loads(self.rfile.read(int(self.headers["content-length"])))
                owner.requests.append(request)
                owner.keys.append(self.headers.get("authorization", ""))
                status, body = answer(request)
                content = body if isinstance(body, bytes) else json.dumps(body).encode()
                self.send_response(status)
                self.send_header("content-type", "application/json")
                self.send_header("content-length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

        self._http = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._http.daemon_threads = False  # so that closing waits for every connection
        self._http.handle_error = lambda *args: None  # a client may leave
        self.url = f"http://127.0.0.1:{self._http.server_port}/v1"
        self._thread = threading.Thread(target=self._http.serve_forever, daemon=True)

    @contextmanager
    def running(self):
        self._thread.start()
        try:
            yield self
        finally:
            self._http.shutdown()
            self._http.server_close()
            self._thread.join()


def completion(text):
    """A successful answer that says this."""
    return 200, {
        "id": "x",
        "object": "chat.completion",
        "created": 1,
        "model": "fake",
        "choices": [{"index": 0, "message": {"role": "assistant", "content": text}, "finish_reason": "stop"}],
        "usage": {"prompt_tokens": 11, "completion_tokens": 5, "total_tokens": 16},
    }


def refusal(status, message):
    """An error of the provider."""
    return status, {"error": {"message": message, "type": "error", "code": status}}


def words(message):
    """The text of a message, whether pictures come with it or not."""
    content = message["content"]
    return content if isinstance(content, str) else " ".join(part["text"] for part in content if part["type"] == "text")


def pictures(message):
    """The pictures of a message: (file, media type, detail) of each."""
    if isinstance(message["content"], str):
        return []
    found = []
    for part in message["content"]:
        if part["type"] == "image_url":
            media, _, data = part["image_url"]["url"].partition(";base64,")
            found.append((base64.b64decode(data, validate=True), media, part["image_url"]["detail"]))
    return found


def truthful(request):
    """A well-formed reply: it repeats what it was told and goes through the joints in the order listed."""
    listing = words(request["messages"][0]).split(" joints: ")[1].split(".")[0].split(", ")
    told = words(request["messages"][-1])
    first = len(request["messages"]) == 1
    said = "none" if first else "did not move" if "did not move" in told else "moved"
    turn = sum(message["role"] == "assistant" for message in request["messages"])
    return completion(json.dumps({"last_action": said, "hypothesis": "in turn", "joint": listing[turn % len(listing)]}))
