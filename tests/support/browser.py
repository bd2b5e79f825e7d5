"""A headless browser for the pages that camopt writes."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ["--no-sandbox", "--disable-gpu"]  # in a container there is neither


@contextmanager
def running_browser() -> Iterator:
    """Chromium, driven by Playwright; the test is skipped where this machine has none."""
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip("no Chromium on this machine (.ci/run installs Debian's)")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=FLAGS)
        yield browser
        browser.close()


@contextmanager
def watched_page(browser, home="file:", **context) -> Iterator:
    """A new page; no error in its program, no line on its console, and no request but to where it is from."""
    troubles: list[str] = []
    with browser.new_context(**context) as opened:
        page = opened.new_page()
        page.on("console", lambda message: troubles.append(f"console: {message.text}"))
        page.on("pageerror", lambda error: troubles.append(f"error: {error}"))
        page.on("dialog", lambda dialog: (troubles.append(f"dialog: {dialog.message}"), dialog.dismiss()))
        page.on("request", lambda request: troubles.extend(_elsewhere(request.url, home)))
        yield page
    assert troubles == []


def _elsewhere(address: str, home: str) -> list[str]:
    return [] if address.startswith((home, "data:", "blob:")) else [f"request: {address}"]


def open_page(page, path) -> None:
    """Open a page of camopt and wait until its program has begun."""
    page.goto(path.as_uri())
    page.wait_for_selector("html[data-ready]")


def box_of(page, selector) -> dict[str, float]:
    """Where the first element that is meant is in the window, after it was scrolled there."""
    found = page.locator(selector).first
    found.scroll_into_view_if_needed()
    return found.bounding_box()


def drag(page, start, end) -> None:
    """Drag from one point of the window to another."""
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(*end, steps=4)
    page.mouse.up()
