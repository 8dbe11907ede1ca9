"""Reports without pictures, and a browser for the tests of pages."""

from __future__ import annotations

import pytest
from explorer_page import BROWSER, DRIVER


@pytest.fixture
def no_pictures(monkeypatch) -> None:
    """A word in place of each picture, whose drawing takes longer than the rest of a report."""
    monkeypatch.setattr("pounding_risk.reports.document.svg_text", lambda figure: "<svg/>")


@pytest.fixture(scope="session")
def driver():
    """Headless Chromium; what it logs and asks for is kept."""
    webdriver = pytest.importorskip("selenium.webdriver")
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for option in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1500,1300"):
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    found = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    yield found
    found.quit()
