"""A real browser, where one is installed, for tests of the page."""

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
WIDTH, HEIGHT = 920, 600  # small, because it is drawn in software
SENT_MS = 200  # the page sends what is typed at most every 50 ms
PATIENCE_MS = 120_000


def missing() -> str:
    """Return the reason why no browser can be used; "" if one can."""
    try:
        import playwright.sync_api  # noqa: F401  # pyright: ignore[reportMissingImports]
    except ImportError:
        return "playwright is not installed: .venv/bin/pip install -e '.[browser]'"
    return "" if executable() else f"no browser: install one of {', '.join(NAMES)}"


def executable() -> str | None:
    """Return the path of `CALOT_CHROMIUM` or Chromium; None if neither is found."""
    found = (shutil.which(name) for name in (os.environ.get(NAMED_BY), *NAMES) if name)
    return next((path for path in found if path), None)


@contextmanager
def browser() -> Iterator[Browser]:
    """Start Chromium without a window, drawing in software."""
    from playwright.sync_api import sync_playwright  # pyright: ignore[reportMissingImports]

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=executable(), args=[*FLAGS])
        yield chromium
        chromium.close()


@contextmanager
def open_tab(
    chromium: Browser, address: str, *, offline: bool = False, script: str = ""
) -> Iterator[Page]:
    """Open a tab on an address; `script` runs before the page's own.

    Raises:
        RuntimeError: When the block is left, if the page had an error.
    """
    errors: list[str] = []
    context = chromium.new_context(viewport={"width": WIDTH, "height": HEIGHT}, offline=offline)
    tab = context.new_page()
    tab.set_default_timeout(PATIENCE_MS)
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.add_init_script(script)
    tab.goto(address)
    yield tab
    context.close()
    if errors:
        raise RuntimeError(f"the page: {'; '.join(errors)}")


def button(tab: Page, name: str) -> Locator:
    """Return the button with this text in the HTML; the style sheet may show another text."""
    return tab.locator("button", has_text=re.compile(rf"^\s*{re.escape(name)}$"))


def press(tab: Page, name: str) -> None:
    """Click a button at once; playwright's own click waits until the page stands still."""
    button(tab, name).dispatch_event("click")


def type_in(tab: Page, text: str) -> None:
    """Type into the line for free text, without pressing Enter."""
    tab.locator("form input").fill(text)
    tab.wait_for_timeout(SENT_MS)


def enter(tab: Page) -> None:
    """Press Enter in the line for free text."""
    tab.locator("form input").press("Enter")
