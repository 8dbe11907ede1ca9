"""The page of `view` as tests read it: its embedded data from the file, and what it shows in headless Chromium."""

from __future__ import annotations

import base64
import json
import shutil
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml.html import HTMLParser, document_fromstring

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
DRIVER = shutil.which("chromedriver")


def needs_browser(test: Any) -> Any:
    """A test in a browser is of the complete ones, and skipped where no browser is installed."""
    without = pytest.mark.skipif(not (BROWSER and DRIVER), reason="no Chromium with its driver is installed")
    return pytest.mark.complete(without(test))


class Page:
    """What stands in a page: scripts' texts by type, the policy, and every attribute that may fetch."""

    def __init__(self, text: str):
        root = document_fromstring(text, parser=HTMLParser(huge_tree=True))
        self.scripts = [(each.get("type", ""), each.text or "") for each in root.iter("script")]
        (self.policy,) = root.xpath("//*[@http-equiv='Content-Security-Policy']/@content")
        self.fetched = root.xpath("//@src | //@href | //@data | //@action | //@srcset")


def embedded(path: Path) -> dict:
    """Data embedded in a page."""
    page = Page(path.read_text(encoding="utf-8"))
    (text,) = [text for kind, text in page.scripts if kind == "application/json"]
    return json.loads(text)


def unpacked(model: dict, variable: dict) -> np.ndarray:
    """A variable's array: deflated, bytes sorted by their place."""
    sizes = {axis["name"]: len(axis["labels"]) for axis in model["axes"]}
    sorted_bytes = np.frombuffer(zlib.decompress(base64.b64decode(variable["data"])), np.uint8)
    plain = np.ascontiguousarray(sorted_bytes.reshape(4, -1).T).reshape(-1)
    return plain.view(f"<{variable['kind']}").reshape([sizes[axis] for axis in variable["dims"]])


class Reader:
    """A page in headless Chromium: what a reader does and sees."""

    def __init__(self, driver, path: Path):
        self.driver = driver
        driver.get(path.as_uri())
        self.until("return document.body.dataset.ready === 'yes' || !document.getElementById('trouble').hidden")

    def until(self, script: str) -> None:
        from selenium.webdriver.support.ui import WebDriverWait

        WebDriverWait(self.driver, 30, 0.02).until(lambda driver: driver.execute_script(script))

    def pick(self, **choices: str) -> None:
        from selenium.webdriver.support.ui import Select

        for name, words in choices.items():
            Select(self.driver.find_element("name", name.replace("_", " "))).select_by_visible_text(words)

    def press(self, *keys: str) -> None:
        self.driver.find_element("id", "map").send_keys(*keys)

    def to_corner(self) -> None:
        """To the first gap and yield force, wherever the page began."""
        self.press("\ue011", "\ue015", "\ue015", "\ue015")

    def click(self, name: str) -> None:
        self.driver.find_element("id", name).click()

    def text(self, name: str) -> str:
        return self.driver.find_element("id", name).text

    def drawn(self) -> dict:
        """The map as Plotly has it: numbers of the cells, and where crosses stand."""
        return self.driver.execute_script(
            "const [heat, crosses] = document.getElementById('map').data;"
            "return {z: heat.z, x: crosses.x, y: crosses.y, zmin: heat.zmin, zmax: heat.zmax}"
        )

    def column(self, place: int) -> dict[str, str]:
        """One column of the table by output."""
        return self.driver.execute_script(
            "return Object.fromEntries([...document.querySelectorAll('#table tbody tr[data-output]')]"
            ".map((row) => [row.dataset.output, row.cells[arguments[0]].textContent]))",
            place,
        )


def number(words: str) -> float:
    """The number that a cell of the table begins with; NaN for what is not there."""
    return np.nan if words == "–" else float(words.replace("−", "-").split()[0])
