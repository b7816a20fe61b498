"""Check in JupyterLab that the card of a drive is drawn without an error; `.ci/site` runs this.

    python -m tests.lab_in_browser PYTHON PICTURE.png

PYTHON is the interpreter of the project's environment, with JupyterLab. JupyterLab replaces an
output whose HTML it cannot draw with an error, which no test of the HTML alone would find.
"""

import json
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

from tests.site_in_browser import PATIENCE, browser, view

CARD = """
from tests.test_drive import STREETS, drive_street, occupied_squares, on_time
print(drive_street(STREETS[0], occupied_squares, seconds=2.0, clock=on_time)._repr_html_())
"""


def notebook_with(html):
    """Return a notebook with one cell that displays HTML."""
    output = {"output_type": "display_data", "data": {"text/html": html}, "metadata": {}}
    cell = {
        "cell_type": "code",
        "id": "drive",
        "execution_count": 1,
        "source": "drive(detect_obstacles)",
        "metadata": {},
        "outputs": [output],
    }
    return {"cells": [cell], "metadata": {}, "nbformat": 4, "nbformat_minor": 5}


def free_port():
    """Return the number of a port that no program uses."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def main(python, picture):
    """Open the card in JupyterLab; return a sentence for each fault."""
    card = subprocess.run([python, "-c", CARD], check=True, capture_output=True, text=True).stdout
    with tempfile.TemporaryDirectory() as folder:
        path, port = Path(folder) / "drive.ipynb", free_port()
        path.write_text(json.dumps(notebook_with(card)))
        subprocess.run([python, "-m", "jupyter", "trust", str(path)], check=True)
        options = ("--no-browser", "--allow-root", f"--port={port}", "--IdentityProvider.token=")
        lab = subprocess.Popen(
            [python, "-m", "jupyterlab", *options, f"--ServerApp.root_dir={folder}"]
        )
        try:
            return list(faults_of_card(f"http://127.0.0.1:{port}/lab/tree/drive.ipynb", picture))
        finally:
            lab.terminate()
            lab.wait()


def faults_of_card(address, picture):
    """Yield a sentence for each fault of the card."""
    driver = browser()
    try:
        view(driver, 1280, "light")
        for _ in range(PATIENCE):
            time.sleep(1)  # the server has to start first
            try:
                driver.get(address)
                break
            except Exception as error:
                reason = error
        else:
            yield f"JupyterLab does not start: {reason}"
            return
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
    finally:
        driver.quit()


if __name__ == "__main__":
    faults = main(*sys.argv[1:])
    print("\n".join(faults) or "No faults in JupyterLab.")
    sys.exit(bool(faults))
