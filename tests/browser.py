"""A headless Chromium for tests of pages: what it says on its console, what it asks of the network, how long its tasks take."""

from __future__ import annotations

import base64
import json
import os
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--force-device-scale-factor=1",
    "--font-render-hinting=none",
)
LONG_TASKS = """
window.longTasks = [];
new PerformanceObserver((list) => { for (const e of list.getEntries()) longTasks.push([e.startTime, e.duration]); })
  .observe({type: "longtask", buffered: true});
"""


def programs() -> tuple[str, str]:
    """Chromium and its driver; the test skips where they are absent, and fails where FAIRAUDIT_BROWSER demands them."""
    found = shutil.which("chromium") or shutil.which("chromium-browser"), shutil.which("chromedriver")
    if found[0] is None or found[1] is None:
        if os.environ.get("FAIRAUDIT_BROWSER"):
            pytest.fail("FAIRAUDIT_BROWSER is set, and chromium or chromedriver is not on the path")
        pytest.skip("chromium and chromedriver are not on the path (Debian: apt-get install chromium chromium-driver)")
    return found[0], found[1]


class Browser:
    """One running Chromium."""

    def __init__(self, profile: Path) -> None:
        chromium, driver = programs()
        if not os.environ.get("FAIRAUDIT_BROWSER"):
            pytest.importorskip("selenium", reason="selenium is not installed (it is in the extra dev)")
        from selenium import webdriver

        options = webdriver.ChromeOptions()
        options.binary_location = chromium
        for flag in (*FLAGS, f"--user-data-dir={profile}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
        self.driver.set_script_timeout(60)
        self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": LONG_TASKS})

    def open(self, page: Path, width: int = 1100, *, dark: bool = False, scripts: bool = True) -> None:
        """Show a page and wait until it has checked itself."""
        command = self.driver.execute_cdp_cmd
        command("Emulation.setDeviceMetricsOverride", {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600})
        command("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})
        deadline = time.monotonic() + 60
        while True:
            command("Emulation.setScriptExecutionDisabled", {"value": not scripts})
            for kind in ("browser", "performance"):
                self.driver.get_log(kind)
            self.driver.get(page.as_uri())
            command("Emulation.setScriptExecutionDisabled", {"value": False})  # what is loaded stays as it is
            if scripts or self.run("return document.getElementById('save')?.hidden !== false"):
                break  # otherwise the page came with a new process, and its script began before the setting reached it
            assert time.monotonic() < deadline, "the page runs scripts although they are switched off"
        while scripts and not self.run("return document.documentElement.dataset.checked"):
            assert time.monotonic() < deadline, "the page did not finish its check"
            time.sleep(0.02)

    def run(self, script: str, *arguments: Any) -> Any:
        """Run a script in the page."""
        return self.driver.execute_script(script, *arguments)

    @property
    def state(self) -> str:
        """What the page found out about itself: agrees, differs, refused or unknown."""
        return str(self.run("return document.documentElement.dataset.checked"))

    @property
    def findings(self) -> list[str]:
        """The statements that the page lists, with their signs."""
        return list(self.run("return [...document.querySelectorAll('#finding-list li')].map((e) => e.textContent)"))

    def console(self) -> list[Any]:
        """Messages since the page was opened: errors, warnings, and what its policy stopped."""
        return list(self.driver.get_log("browser"))

    def requests(self) -> list[str]:
        """Addresses that the page asked for; those of the browser's own empty tab before it may come late, and are left out.

        So are those of what the page itself made: the script of its worker.
        """
        messages = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        asked = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
        return [address for address in asked if not address.startswith(("chrome://", "blob:"))]

    def picture(self, height: int) -> bytes:
        """The page from its top, as PNG, in a font that does not depend on the machine's choice."""
        self.run("document.documentElement.style.fontFamily = 'DejaVu Sans'; window.scrollTo(0, 0);")
        width = self.run("return innerWidth")
        clip = {"x": 0, "y": 0, "width": width, "height": height, "scale": 1}
        shot = self.driver.execute_cdp_cmd("Page.captureScreenshot", {"captureBeyondViewport": True, "clip": clip})
        return base64.b64decode(shot["data"])

    def close(self) -> None:
        """End it."""
        self.driver.quit()


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """The one browser of a run."""
    running = Browser(tmp_path_factory.mktemp("chromium"))
    yield running
    running.close()
