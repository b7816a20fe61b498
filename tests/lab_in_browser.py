"""Check a drive's card and a drawing to change by hand in JupyterLab; `.ci/site` runs this.

    python -m tests.lab_in_browser PYTHON PICTURE.png DRAWING.png

PYTHON is the interpreter of the project's environment, with JupyterLab. JupyterLab replaces an
output whose HTML it cannot draw with an error, which no test of the HTML alone would find. The
script drags a point of the drawing, moves it with the keyboard and lets the function fail. The
line has to follow.
"""

import contextlib
import json
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from selenium.common.exceptions import TimeoutException, WebDriverException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

from tests.site_in_browser import PATIENCE, PROJECT, browser, view

CARD = """
from utils.drive import STREETS, drive_street, occupied_squares, on_time
print(drive_street(STREETS[0], occupied_squares, seconds=2.0, clock=on_time)._repr_html_())
"""
# A line through the point that can be dragged, at right angles to the y axis.
DRAWING = f"""
import sys; sys.path.insert(0, {str(PROJECT)!r})
from utils.by_hand import Drawing, drag_points
def level(points):
    height = points[1][1]
    if height > 3:
        raise ValueError("too high")
    return Drawing(f"at {{height:.2f}} m", labels=[1, 2], lines={{"level": (0, 1, -height)}})
drag_points(level, [[0, 0], [1, 1]], movable=[1], limits=((-5, 5), (-4, 4)))
"""


def notebook_with(source, html=""):
    """Return a notebook with one cell, which may already display HTML."""
    output = {"output_type": "display_data", "data": {"text/html": html}, "metadata": {}}
    cell = {
        "cell_type": "code",
        "id": "only",
        "execution_count": 1 if html else None,
        "source": source,
        "metadata": {},
        "outputs": [output] if html else [],
    }
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    metadata = {"kernelspec": kernel}  # otherwise, JupyterLab asks for a kernel
    return {"cells": [cell], "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}


def free_port():
    """Return the number of a port that no program uses."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def main(python, *pictures):
    """Open both notebooks in JupyterLab; return a sentence for each fault."""
    card = subprocess.run([python, "-c", CARD], check=True, capture_output=True, text=True).stdout
    notebooks = {
        "drive": notebook_with("drive(detect_obstacles)", card),
        "by_hand": notebook_with(DRAWING),
    }
    with tempfile.TemporaryDirectory() as folder:
        port = free_port()
        for name, notebook in notebooks.items():
            path = Path(folder) / f"{name}.ipynb"
            path.write_text(json.dumps(notebook))
            subprocess.run([python, "-m", "jupyter", "trust", str(path)], check=True)
        options = ("--no-browser", "--allow-root", f"--port={port}", "--IdentityProvider.token=")
        lab = subprocess.Popen(
            [python, "-m", "jupyterlab", *options, f"--ServerApp.root_dir={folder}"]
        )
        try:
            address = f"http://127.0.0.1:{port}/lab/tree"
            return [
                *faults_of_card(f"{address}/drive.ipynb", pictures[0]),
                *faults_of_drawing(f"{address}/by_hand.ipynb", pictures[1]),
            ]
        finally:
            lab.terminate()
            lab.wait()


@contextlib.contextmanager
def opened(address):
    """Open a notebook, as soon as the server has started, and yield the browser."""
    driver = browser()
    try:
        view(driver, 1280, "light")
        for _ in range(PATIENCE):
            time.sleep(1)
            try:
                driver.get(address)
                break
            except Exception as error:
                reason = error
        else:
            raise RuntimeError(f"JupyterLab does not start: {reason}")
        yield driver
    finally:
        driver.quit()


def faults_of_card(address, picture):
    """Yield a sentence for each fault of the card."""
    with opened(address) as driver:
        drawn = WebDriverWait(driver, PATIENCE).until(
            lambda page: page.find_elements(By.CSS_SELECTOR, ".jp-OutputArea-child")
        )
        time.sleep(5)
        driver.save_screenshot(picture)
        text = " ".join(output.text for output in drawn)
        if "A quiet street" not in text:
            yield f"the card does not name its street: {text}"
        if "Error" in text:
            yield f"the card of a drive shows an error: {text}"


def faults_of_drawing(address, picture):
    """Yield a sentence for each fault of the drawing: it must follow the mouse and the keyboard."""
    with opened(address) as driver:

        def wait(condition):
            with contextlib.suppress(TimeoutException):
                patient = WebDriverWait(driver, PATIENCE, ignored_exceptions=[WebDriverException])
                return patient.until(condition)

        def find(selector):
            return driver.find_element(By.CSS_SELECTOR, selector)

        def title():
            return find(".by-hand-title").text

        def line_height():
            return float(find(".by-hand-line").get_attribute("y1"))

        def place():
            return float(handle.get_attribute("aria-label").replace("−", "-").split()[-3][:-2])

        def has_followed():
            return title() == f"at {place():.2f} m"

        wait(
            lambda _: find(".jp-Notebook-ExecutionIndicator").get_attribute("data-status") == "idle"
        )
        wait(lambda _: find(".jp-CodeCell .cm-content").click() or True)
        ActionChains(driver).key_down(Keys.SHIFT).send_keys(Keys.ENTER).key_up(Keys.SHIFT).perform()
        if not wait(lambda _: find(".by-hand-handle").is_displayed()):
            yield "the drawing does not appear"
            return
        if any(
            still.is_displayed()
            for still in driver.find_elements(By.CSS_SELECTOR, "[class^=still]")
        ):
            yield "the figure is shown together with the drawing"
        handle, before = find(".by-hand-handle"), line_height()
        mouse = ActionChains(driver).move_to_element(handle).click_and_hold()
        for _ in range(10):
            mouse.move_by_offset(0, 10)
        mouse.release().perform()
        if not wait(lambda _: place() < 0.5 and has_followed()) or line_height() < before + 20:
            yield f"the line does not follow the mouse: {title()}"
        dragged = place()
        ActionChains(driver).send_keys(Keys.ARROW_UP).perform()
        if not wait(lambda _: place() > dragged + 0.05 and has_followed()):
            yield f"the line does not follow the keyboard: {title()}"
        driver.save_screenshot(picture)
        upwards = ActionChains(driver).key_down(Keys.SHIFT)
        for _ in range(10):
            upwards.send_keys(Keys.ARROW_UP)
        upwards.key_up(Keys.SHIFT).perform()
        if not wait(lambda _: "level raised ValueError: too high" in find(".by-hand-message").text):
            yield f"the exception is not shown: {find('.by-hand-message').text}"
        find(".by-hand button").click()
        if not wait(lambda _: title() == "at 1.00 m" and not find(".by-hand-message").text):
            yield f"the drawing does not start again: {title()}"


if __name__ == "__main__":
    faults = main(*sys.argv[1:])
    print("\n".join(faults) or "No faults in JupyterLab.")
    sys.exit(bool(faults))
