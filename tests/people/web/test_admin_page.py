"""The experimenter's page in a real browser: with a mouse, with a keyboard, on a phone, in the dark, and through axe."""

import asyncio

from browser import browser, needs_a_browser, run, violations
from served import at_the_box, served, visiting

from lockprobe.interfaces.export.downloads import downloads
from lockprobe.people.web.admin import AdminPage

pytestmark = needs_a_browser


LOOKS = [(1280, "light"), (1280, "dark"), (375, "light"), (360, "dark"), (320, "light")]
"""Widths of the window in pixels, and colour schemes; axe looks at the widest and at the narrowest of each scheme."""

AXE = {(1280, "light"), (1280, "dark"), (360, "dark"), (320, "light")}


async def check_looks(page):
    """Nothing that axe finds, and nothing beside the screen or cut off in a table."""
    for width, scheme in LOOKS:
        await page.set_viewport_size({"width": width, "height": 740})
        await page.emulate_media(color_scheme=scheme)
        assert (width, scheme) not in AXE or await violations(page) == []
        assert await page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        scrolled = "[...document.querySelectorAll('.scroll')].every(t => t.scrollWidth <= t.clientWidth)"
        assert await page.evaluate(scrolled), (width, scheme)


def test_somebody_is_withdrawn_on_the_page(tmp_path):
    async def visit():
        async with served(tmp_path) as place, visiting(place) as one, visiting(place) as other, browser() as chromium:
            await asyncio.gather(one.play(), at_the_box(other, step=2))
            context = await chromium.new_context()
            page, wrong, hosts = await context.new_page(), [], set()
            page.on("pageerror", lambda error: wrong.append(str(error)))
            page.on("request", lambda request: hosts.add(request.url.split("/")[2]))
            await page.goto(f"{place.url}admin")
            await check_looks(page)
            await page.keyboard.type("not-the-token")
            await page.keyboard.press("Enter")
            await page.wait_for_selector("#status.wrong")
            assert await page.locator("#study").is_hidden()
            await page.goto(f"{place.url}admin#token=a-token-for-tests")
            button = page.get_by_role("button", name=f"Withdraw participant {one.identity}")
            await button.wait_for()
            assert page.url == f"{place.url}admin"
            assert await page.locator("#participants tbody tr").count() == 2
            await check_looks(page)
            names = await page.locator("#conditions tbody th").all_inner_texts()
            assert names == ["truth", "flip?p=0.4"]
            await button.focus()
            await page.keyboard.press("Enter")
            await page.get_by_role("dialog", name="Withdraw and delete").wait_for()
            assert one.identity in await page.locator("#sure").inner_text()
            await check_looks(page)
            await page.keyboard.press("Escape")
            assert await page.locator("#participants tbody tr").count() == 2
            await button.click()
            await page.get_by_role("button", name="Delete everything").click()
            await page.locator("#status", has_text="has been deleted").wait_for()
            assert await page.locator("#participants tbody tr").count() == 1
            await check_looks(page)
            await page.reload()  # the tab still knows the token
            await page.locator("#participants tbody tr").wait_for()
            await page.get_by_role("button", name="Forget the token").click()
            await page.reload()
            assert await page.locator("#door").is_visible()
            assert wrong == []
            assert len(hosts) == 1
            await context.close()
            return one.identity

    gone = run(visit())
    assert not (tmp_path / "people" / f"{gone}.jsonl").exists()


def test_the_data_are_downloaded_on_the_page(tmp_path):
    async def visit():
        desk = AdminPage(files=downloads(tmp_path))
        async with served(tmp_path, desk=desk) as place, visiting(place) as one, browser() as chromium:
            page = await (await chromium.new_context()).new_page()
            await page.goto(f"{place.url}admin#token=a-token-for-tests")
            everything = page.get_by_role("button", name="Download everything (ZIP)")
            await everything.wait_for()
            assert await everything.is_disabled()  # nobody has taken part
            await one.play()
            await page.reload()
            await page.locator("#everything:enabled").wait_for()
            await check_looks(page)
            names = []
            for name in (
                "Download everything (ZIP)",
                "Download trials.csv",
                "Download the columns of trials.csv, described",
            ):
                async with page.expect_download() as coming:
                    await page.get_by_role("button", name=name, exact=True).click()
                names.append((await coming.value).suggested_filename)
            await page.locator("#prepared", has_text="trials.csv-metadata.json is downloaded").wait_for()
            await check_looks(page)
            return names

    assert run(visit()) == ["dataset.zip", "trials.csv", "trials.csv-metadata.json"]
