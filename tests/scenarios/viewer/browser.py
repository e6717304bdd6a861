"""A real browser, where there is one."""

import os
import shutil
from contextlib import contextmanager

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
SIZE = {"width": 920, "height": 600}  # small, as it draws in software


def missing():
    """Why there is none; "" if there is one."""
    try:
        import playwright.sync_api  # noqa: F401
    except ImportError:
        return "playwright is not installed: pip install 'calot[browser]'"
    return "" if executable() else f"no browser: install one of {', '.join(NAMES)}"


def executable():
    """Path of a Chromium; None if there is none. `CALOT_CHROMIUM` names another one."""
    named = os.environ.get("CALOT_CHROMIUM")
    found = (shutil.which(name) for name in (named, *NAMES) if name)
    return next((path for path in found if path), None)


needs_browser = [
    pytest.mark.browser,
    pytest.mark.skipif(bool(missing()), reason=missing() or "there is one"),
]


@contextmanager
def browser():
    """Chromium without a window, drawing in software."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=executable(), args=[*FLAGS])
        yield chromium
        chromium.close()


@contextmanager
def open_tab(chromium, address, *, offline=False):
    """A tab in which any error on the page fails the test."""
    errors = []
    context = chromium.new_context(viewport=SIZE, offline=offline)
    tab = context.new_page()
    tab.set_default_timeout(120_000)
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.goto(address)
    yield tab
    context.close()
    assert not errors, errors
