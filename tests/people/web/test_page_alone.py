"""The page with a server that loses replies, refuses and moves on: what it sends, and what it shows then."""

import json
from contextlib import asynccontextmanager
from functools import wraps
from pathlib import Path

import numpy as np
from browser import browser, needs_a_browser, run

import lockprobe.people.web
from lockprobe.people.experiment import read_words

pytestmark = needs_a_browser

STATIC = Path(lockprobe.people.web.__file__).with_name("static")
KINDS = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'"
HOME = "http://page.test/"

LOST, DOWN = "lost", (503, {})
WORDS = read_words("de").model_dump(mode="json", include={"language", "direction", "title", "page"})
INCOMPLETE = (400, {"error": "incomplete", "message": "it is incomplete", "words": WORDS})
THREE = tuple((label, "revolute", (0.5, 0.5)) for label in "BAC")


def a_box(step=1, joints=THREE, **more):
    drawn = [
        {"label": label, "target": label == "A", "kind": kind, "place": place, "position": 0}
        for label, kind, place in joints
    ]
    panel = {"view": "panel", "joints": drawn, "report": ["said"], "last": None, "outcome": None, "pictures": []}
    return {"kind": "box", "practice": False, "number": 1, "of": 2, "step": step, "budget": 20, "ask": False,
            "panel": panel, "history": [], "spoken": "said aloud", **more}  # fmt: skip


class Server:
    """Shows the next scene after every act; before that it answers as it was told to.

    Attributes:
        scenes: What is shown, one after the other; the last stays.
        troubles: For a path, what comes before the answer: a refusal, or a reply that is lost.
        posts: What came: path and body.
    """

    def __init__(self, *scenes, **troubles):
        self.scenes = list(scenes)
        self.troubles = {path: list(answers) for path, answers in troubles.items()}
        self.posts = []
        self.turn = 1

    async def answer(self, route):
        path = route.request.url.removeprefix(HOME).partition("?")[0]
        if not path.startswith("api/"):
            file = STATIC / (path or "index.html")
            headers = {"content-type": KINDS[file.suffix], "content-security-policy": POLICY}
            await route.fulfill(body=file.read_bytes(), headers=headers)
            return
        path, body = path.removeprefix("api/"), json.loads(route.request.post_data)
        self.posts.append((path, body))
        trouble = self.troubles.get(path, [])
        first = trouble.pop(0) if trouble else None
        if first == LOST:
            await route.abort("connectionreset")
        elif first:
            await route.fulfill(status=first[0], json=first[1])
        else:
            if path == "act":
                self.turn += 1
                self.scenes = self.scenes[1:] or self.scenes
            words = {"words": WORDS} if path == "open" else {}
            await route.fulfill(json={"turn": self.turn, "scene": self.scenes[0], "participant": "me", **words})

    def sent(self, path):
        return [body for at, body in self.posts if at == path]


@asynccontextmanager
async def page_of(server, query="", **settings):
    """The page as it shows the first scene."""
    async with browser() as chromium:
        page = await (await chromium.new_context(**settings)).new_page()
        await page.route("**/*", server.answer)
        page.set_default_timeout(20_000)
        await page.goto(HOME + query)
        yield page


async def shown(page, turn):
    await page.wait_for_selector(f"#scene[data-turn='{turn}'] h1")


def played(test):
    """A test of the page runs in the loop of the browser."""
    return wraps(test)(lambda **fixtures: run(test(**fixtures)))


@played
async def test_an_act_without_a_reply_is_sent_again_as_it_was_and_it_is_said():
    server = Server(a_box(), a_box(2), act=[LOST, DOWN])
    async with page_of(server) as page:
        await page.click("[data-joint=B]")
        await page.wait_for_selector(f"#trouble p:has-text('{WORDS['page']['offline']}')")
        await shown(page, 2)
        first, *again = server.sent("act")
        assert again == [first] * 2
        assert (first["turn"], first["act"]["joint"]) == (1, "B")
        assert await page.inner_text("#trouble") == ""


@played
async def test_a_link_that_the_platform_did_not_fill_in_is_said_and_not_tried_again():
    server = Server(a_box(), open=[INCOMPLETE] * 9)
    async with page_of(server, "?PROLIFIC_PID={{%PROLIFIC_PID%}}") as page:
        await page.wait_for_selector("dialog[open]")
        assert await page.inner_text("dialog") == WORDS["page"]["incomplete"]
        assert await page.title() == WORDS["title"]
        assert await page.locator("button").count() == 0
        await page.keyboard.press("Escape")
        await page.keyboard.press("Escape")
        await page.wait_for_timeout(50)
        await page.wait_for_selector("dialog[open]")
        assert len(server.sent("open")) == 1


@played
async def test_a_double_click_is_one_choice_and_so_is_a_key_that_is_held_down():
    server = Server(*(a_box(step) for step in range(1, 9)))
    async with page_of(server) as page:
        await page.dblclick("[data-joint=B]")
        await shown(page, 2)
        for key, turn in (("c", 3), ("Enter", 4)):
            await page.focus("[data-joint=A]")
            for _ in range(4):
                await page.keyboard.down(key)
                await page.wait_for_timeout(100)
            await page.keyboard.up(key)
            await shown(page, turn)
        await page.wait_for_timeout(100)
        assert [body["act"]["joint"] for body in server.sent("act")] == ["B", "C", "A"]


@played
async def test_times_are_of_the_scene_as_it_was_painted_and_of_the_claim_apart():
    server = Server(a_box(2, ask=True), a_box(3))
    async with page_of(server) as page:
        await shown(page, 1)
        await page.wait_for_timeout(300)
        await page.click("[data-joint=A]", force=True)  # not before it is said what the last action did
        assert not server.sent("act")
        await page.click("[data-claim=blocked]")
        await page.click("[data-claim=moved]", force=True)  # answered once
        await page.wait_for_timeout(200)
        await page.keyboard.press("a")
        await shown(page, 2)
        (body,) = server.sent("act")
        act = body["act"]
        assert (act["kind"], act["joint"], act["claimed"]) == ("attempt", "A", "blocked")
        assert 300 <= act["claimed_rt"] < 10_000
        assert 200 <= act["rt"] < act["claimed_rt"] + 10_000


@played
async def test_drawn_joints_never_lie_on_each_other_however_they_sit_on_the_panel():
    luck = np.random.default_rng(3)
    panels = [[(0.5, 0.5)] * 8, [(0.5, 0.5)] * 2, [(i / 7, 0.5) for i in range(8)], [(0.1, i / 5) for i in range(6)]]
    panels += [luck.random((count, 2)).round(3).tolist() for count in range(3, 9)]
    kinds = ("prismatic", "revolute") * 4

    def scene(places):
        return a_box(joints=list(zip("ABCDEFGH", kinds, places, strict=False)))

    server = Server(*map(scene, panels), scene(panels[0]))
    async with page_of(server, viewport={"width": 360, "height": 740}) as page:
        for turn, places in enumerate(panels, 1):
            await shown(page, turn)
            boxes = await page.eval_on_selector_all(
                "[data-joint]", "all => all.map(one => one.getBoundingClientRect().toJSON())"
            )
            assert len(boxes) == len(places)
            assert min(min(at["width"], at["height"]) for at in boxes) >= 44
            assert min(at["left"] for at in boxes) >= 0
            assert max(at["right"] for at in boxes) <= 360
            for i, one in enumerate(boxes):
                for j, other in enumerate(boxes[:i]):
                    apart = one["left"] >= other["right"] - 0.01 or other["left"] >= one["right"] - 0.01
                    above = one["top"] >= other["bottom"] - 0.01 or other["top"] >= one["bottom"] - 0.01
                    assert apart or above, places
                    x, x_other = places[i][0], places[j][0]
                    assert (x - x_other) * (one["left"] - other["left"]) >= -0.01, "left is left"
            await page.click("[data-joint=A]")
