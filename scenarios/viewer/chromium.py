"""A real browser, where there is one, for what has to be tried in one."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import (  # pyright: ignore[reportMissingImports]
        Browser,
        Locator,
        Page,
    )

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
NAMED_BY = "CALOT_CHROMIUM"
FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
WIDTH, HEIGHT = 920, 600  # small, as it draws in software
SENT_MS = 200  # the page sends what is typed at most every 50 ms
PATIENCE_MS = 120_000


def missing() -> str:
    """Why there is none; "" if there is one."""
    try:
        import playwright.sync_api  # noqa: F401  # pyright: ignore[reportMissingImports]
    except ImportError:
        return "playwright is not installed: pip install 'calot[browser]'"
    return "" if executable() else f"no browser: install one of {', '.join(NAMES)}"


def executable() -> str | None:
    """Path of a Chromium; None if there is none. `CALOT_CHROMIUM` names another one."""
    found = (shutil.which(name) for name in (os.environ.get(NAMED_BY), *NAMES) if name)
    return next((path for path in found if path), None)


@contextmanager
def browser() -> Iterator[Browser]:
    """Chromium without a window, drawing in software."""
    from playwright.sync_api import sync_playwright  # pyright: ignore[reportMissingImports]

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=executable(), args=[*FLAGS])
        yield chromium
        chromium.close()


@contextmanager
def open_tab(chromium: Browser, address: str, *, offline: bool = False) -> Iterator[Page]:
    """A tab.

    Raises:
        RuntimeError: there was an error on the page; when the block is left.
    """
    errors: list[str] = []
    context = chromium.new_context(viewport={"width": WIDTH, "height": HEIGHT}, offline=offline)
    tab = context.new_page()
    tab.set_default_timeout(PATIENCE_MS)
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.goto(address)
    yield tab
    context.close()
    if errors:
        raise RuntimeError(f"the page: {'; '.join(errors)}")


def button(tab: Page, name: str) -> Locator:
    """By its own text: style sheets may show another."""
    return tab.locator("button", has_text=re.compile(rf"^\s*{re.escape(name)}$"))


def press(tab: Page, name: str) -> None:
    """At once, as a person with a fast machine: playwright's own waits for a still picture."""
    button(tab, name).dispatch_event("click")


def type_in(tab: Page, text: str) -> None:
    """Into the line for what is said; Enter is left to be pressed."""
    tab.locator("form input").fill(text)
    tab.wait_for_timeout(SENT_MS)


def enter(tab: Page) -> None:
    """Sends what was typed."""
    tab.locator("form input").press("Enter")
