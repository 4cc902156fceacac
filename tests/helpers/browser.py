"""Pages in a headless Chromium.

It reads their console, their requests to the network, and the width of a page.
"""

import json
import shutil
from contextlib import contextmanager

import pytest

DRIVER, BROWSER = shutil.which("chromedriver"), shutil.which("chromium")
FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--hide-scrollbars", "--allow-file-access-from-files=false",
)  # fmt: skip
SECONDS = 60  # until all plots of a page are drawn, on a busy machine


@contextmanager
def browser(tmp_path):
    """A Chromium that keeps logs of its console and of the network."""
    if DRIVER is None or BROWSER is None:
        pytest.skip("chromium and chromedriver are not installed")
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for flag in (*FLAGS, f"--user-data-dir={tmp_path}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    try:
        yield driver
    finally:
        driver.quit()


def shown(driver, path, width, dark=False):
    """Load a page at a width, and wait until its plots are drawn."""
    driver.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600},
    )
    scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": [scheme]})
    driver.get_log("performance")
    driver.get(path.as_uri())
    if driver.execute_script("return document.querySelectorAll('figure.plot').length"):
        from selenium.webdriver.support.ui import WebDriverWait

        WebDriverWait(driver, SECONDS).until(
            lambda each: each.execute_script("return document.documentElement.dataset.drawn")
        )


def errors(driver):
    """Errors and warnings on the console."""
    return [entry["message"] for entry in driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]


def requests(driver):
    """Addresses that were asked for, but for the page itself and what stands in it."""
    messages = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    sent = [each["params"]["request"]["url"] for each in messages if each["method"] == "Network.requestWillBeSent"]
    return [
        url
        for url in sent
        if not url.startswith(("data:", "blob:")) and url.partition("#")[0] != driver.current_url.partition("#")[0]
    ]


def overflow(driver):
    """px by which a page is wider than its window."""
    return driver.execute_script("return document.documentElement.scrollWidth - document.documentElement.clientWidth")
