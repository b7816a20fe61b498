"""Solve lessons in the pages of a site that was built with `--live`; `.ci/site` runs this script.

    python -m tests.live_in_browser SITE PYTHON AXE.js PICTURES [LESSON ...]

In lesson 06, the script acts as a student. It writes a wrong answer, an endless loop and the right
answer, moves sliders, and downloads the notebook, which the judge must give full marks. In the
other lessons, each check must pass with the lesson's own solution. The browser cannot reach any
other machine, and the page may not try to. PYTHON is an interpreter with the course's packages.
"""

import functools
import html
import http.server
import json
import re
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from tests.site_in_browser import (
    AXE,
    WAIT_UNTIL_SETTLED,
    _QuietHandler,
    browser,
    on_other_hosts,
    requested_addresses,
    view,
)

PROJECT = Path(__file__).parent.parent
LESSON = "06_filter_ground"
RIGHT = {
    "filter_ground": "def filter_ground(cloud, ground_level=-1.2):\n"
    "    return cloud[cloud[:, 2] >= ground_level]\n",
    "voxel_grid": "def voxel_grid(cloud, voxel_size=0.2):\n"
    "    if len(cloud) == 0:\n"
    "        return cloud[:0].astype(float)\n"
    "    cells = np.floor(cloud[:, :3] / voxel_size)\n"
    "    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)\n"
    "    sums = np.zeros((len(count), cloud.shape[1]))\n"
    "    np.add.at(sums, which.ravel(), cloud)\n"
    "    return sums / count[:, None]\n",
}
WRONG = RIGHT["filter_ground"].replace(">=", "<=")
PRINTING = RIGHT["filter_ground"].replace(
    "    return", "    print('a level of', round(ground_level, 2))\n    return"
)
ENDLESS = RIGHT["filter_ground"] + "while True:\n    pass\n"
ENDS = (
    "Computed",
    "The picture below",
    "Checked",
    "Done",
    "Your code has",
    "Stopped",
    "Python cannot",
    "Python ended",
)
PATIENCE = 1800  # seconds for one press of a button, on a machine with other work
VIEWS = ((480, "light"), (480, "dark"), (1280, "light"), (1280, "dark"))
LOADED = """
return performance.getEntriesByType("resource").map((entry) => entry.name)
  .filter((name) => /worker[.]js$|[.]bin$/.test(name));
"""
OTHER_HOST = """
const done = arguments[arguments.length - 1];
fetch("https://example.org/").then(() => done("allowed"), () => done("refused"));
"""


class Panel:
    """The editor, buttons and outputs of an exercise on a page."""

    def __init__(self, driver, name):
        self.driver, self.name = driver, name
        self.box = driver.find_element(By.CSS_SELECTOR, f'.live[aria-label="Write {name}"]')

    @classmethod
    def of_slider(cls, driver, title):
        """Return the sliders whose titles contain a word, with their pictures."""
        panel = cls.__new__(cls)
        panel.driver, panel.name = driver, title
        panel.box = driver.find_element(
            By.XPATH, f"//fieldset[contains(@class, 'positions')][contains(., '{title}')]"
        )
        return panel

    def find(self, selector):
        return self.box.find_elements(By.CSS_SELECTOR, selector)

    def open(self):
        """Open the editor, unless kept code has opened it."""
        if not self.find(".cm-content"):
            self.press("open")
        self.wait(lambda: self.find(".cm-content"), "the editor does not open")

    def press(self, name):
        (button,) = self.find(f"button.{name}:not([hidden])")
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", button)
        button.click()

    def write(self, text):
        """Replace all code, as if it were pasted."""
        (content,) = self.find(".cm-content")
        self.driver.execute_script("arguments[0].focus()", content)
        for key in ("rawKeyDown", "keyUp"):
            self.driver.execute_cdp_cmd(
                "Input.dispatchKeyEvent",
                {
                    **{"type": key, "modifiers": 2, "key": "a", "code": "KeyA"},
                    **{"windowsVirtualKeyCode": 65, "commands": ["selectAll"]},
                },
            )
        self.driver.execute_cdp_cmd("Input.insertText", {"text": text})

    def text(self):
        lines = self.find(".cm-line")
        return self.driver.execute_script(
            "return arguments[0].map((line) => line.textContent).join('\\n')", lines
        )

    def state(self):
        return self.box.find_element(By.CSS_SELECTOR, ".state").text

    def outputs(self):
        (box,) = self.find(".outputs")
        return box.get_attribute("textContent")

    def html(self):
        (box,) = self.find(".outputs")
        return box.get_attribute("innerHTML")

    def wait(self, condition, fault):
        until = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > until:
                raise AssertionError(f"{fault}: {self.state()}")
            time.sleep(0.1)

    def run(self, button):
        """Press a button and wait for one of the final states, which is returned."""
        return self.end_of(button, lambda: self.press(button))

    def move(self, key):
        """Press a key in a slider and wait for one of the final states, which is returned."""
        (slider,) = self.find(".sliders:not([hidden]) input")
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", slider)
        self.driver.execute_script("arguments[0].textContent = ''", *self.find(".state"))
        return self.end_of(
            f"slider at {slider.get_attribute('aria-valuetext')}", lambda: slider.send_keys(key)
        )

    def shown_pictures(self):
        """Return the alternative texts of the pictures that are visible."""
        return [
            picture.get_attribute("alt") for picture in self.find("img") if picture.is_displayed()
        ]

    def end_of(self, action, act):
        """Do something and wait for one of the final states, which is returned."""
        start = time.monotonic()
        act()
        self.wait(lambda: self.state().startswith(ENDS), "the code does not end")
        seconds = time.monotonic() - start
        print(f"{self.name}, {action}: {self.state()} {seconds:.0f} s", flush=True)
        return self.state()


def card_in_notebook(python, name):
    """Return the text of the card that `check` shows in a notebook for the wrong answer."""
    kernel = str(PROJECT / "grader" / "site" / "live" / "guest")
    run = f"import sys; sys.path.insert(0, {kernel!r}); import kernel\n" + "".join(
        f"kernel.run({cell!r})\n"
        for cell in (
            f"import sys; sys.path.insert(0, {str(PROJECT)!r})",
            "import numpy as np\nfrom utils import check",
            WRONG,
            f"check({name})",
        )
    )
    done = subprocess.run(
        [python, "-c", run],
        env={"CHANNEL": "1", "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        check=True,
    )
    sent = [json.loads(line) for line in done.stdout.splitlines()]
    card = [m["data"] for m in sent if m.get("type") == "text/html"][-1]
    # In the browser, no second process can look for the line to change. Therefore, there is no such
    # hint, and nothing shows that the failures have the same reason.
    card = re.sub("<details><summary>Where to look.*?</details>", "", card)
    return words_of(re.sub("<summary>[^<]* for the same reason", "", card))


def words_of(markup):
    """Return the words of the text in HTML."""
    return re.findall(r"\w+", html.unescape(re.sub("<[^>]*>", " ", markup)))


def faults_of_solving(driver, root, python, axe, pictures, downloads):
    """Solve lesson 06 like a student; yield a sentence for each fault."""
    driver.get(f"{root}stage3_obstacles/{LESSON}.html")
    driver.execute_async_script(WAIT_UNTIL_SETTLED)
    if driver.execute_async_script(OTHER_HOST) != "refused":
        yield "the page may ask another host"
    sliders = Panel.of_slider(driver, "level (m)")
    if "MB" not in sliders.state() or not sliders.find("button.open"):
        yield f"a slider does not say how much it will load: {sliders.state()}"
    panel = Panel(driver, "filter_ground")
    panel.open()
    if loaded := driver.execute_script(LOADED):
        yield f"the page loads {loaded} before anything runs"
    if "MB" not in panel.state():
        yield f"the page does not say how much it will load: {panel.state()}"

    panel.write(WRONG)
    end = panel.run("check")
    if end != "Checked.":
        yield f"a wrong answer ends with {end}"
        return
    missing = set(card_in_notebook(python, "filter_ground")) - set(words_of(panel.html()))
    if missing:
        yield f"the card lacks {sorted(missing)}: {panel.outputs()}"
    yield from faults_in_views(driver, {"live": panel.box}, axe, pictures)
    yield from faults_of_sliders(driver, panel, axe, pictures)

    panel.run("run")
    if not panel.find(".outputs img"):
        yield "Run shows no pictures"
    driver.save_screenshot(str(pictures / "live_run.png"))

    panel.write(ENDLESS)
    panel.press("run")
    panel.wait(lambda: panel.state() == "Running your code", "the loop does not begin")
    panel.press("stop")
    panel.wait(lambda: panel.state().startswith("Stopped"), "the loop does not end")
    print(panel.state(), flush=True)
    driver.get(driver.current_url)
    panel = Panel(driver, "filter_ground")
    panel.open()
    if any(slider.is_displayed() for slider in driver.find_elements(By.CSS_SELECTOR, ".sliders")):
        yield "before Python runs, the page shows sliders"
    if panel.text().strip() != ENDLESS.strip():
        yield f"after a stop and a reload, the code is {panel.text()!r}"

    for name, source in RIGHT.items():
        panel = Panel(driver, name)
        panel.open()
        panel.write(source)
        end = panel.run("check")
        if end != "Checked." or "passed" not in panel.outputs() or "failed" in panel.outputs():
            yield f"{name}: {end} {panel.outputs()}"
    progress = driver.find_element(By.CSS_SELECTOR, ".progress-so-far").text
    if f"{len(RIGHT)} exercises passed" not in progress:
        yield f"after all checks have passed, the progress is {progress!r}"
    driver.execute_script("arguments[0].scrollIntoView({block: 'start'})", panel.box)
    driver.save_screenshot(str(pictures / "live_passed.png"))
    panel.press("download")
    notebook = downloads / f"{LESSON}.ipynb"
    panel.wait(notebook.exists, "the notebook is not downloaded")
    judged = subprocess.run(
        [python, "-m", "grader", "judge", str(notebook), "--json"],
        cwd=PROJECT,
        capture_output=True,
        text=True,
    )
    verdict = json.loads(judged.stdout)
    print(f"The judge gives {verdict['score']} of {verdict['max_score']} points.", flush=True)
    if verdict["score"] != verdict["max_score"]:
        yield f"the judge gives {verdict['score']} points"


def faults_in_views(driver, boxes, axe, pictures):
    """Save a picture of each box, by its name, in each view; yield what axe finds."""
    for width, theme in VIEWS:
        view(driver, width, theme)
        for name, box in boxes.items():
            driver.execute_script("arguments[0].scrollIntoView({block: 'start'})", box)
            time.sleep(0.5)
            driver.save_screenshot(str(pictures / f"{name}_{width}_{theme}.png"))
        driver.execute_script(axe)
        for violation in driver.execute_async_script(AXE):
            yield f"{', '.join(boxes)}, {width} pixels, {theme}: {violation}"
    view(driver, 1280, "light")


def faults_of_sliders(driver, panel, axe, pictures):
    """Move the sliders of lesson 06 while Python runs; yield a sentence for each fault."""
    cells = Panel.of_slider(driver, "cell (m)")
    prepared = cells.shown_pictures()
    end = cells.move(Keys.ARROW_RIGHT)
    if "voxel_grid is not written yet" not in cells.outputs() or not end.startswith("The picture"):
        yield f"without code, a moved slider says: {end} {cells.outputs()}"
    if cells.shown_pictures() != prepared or len(prepared) != 1:
        yield f"without code, {prepared} becomes {cells.shown_pictures()}"
    if not any(button.is_displayed() for button in cells.find("input[type=radio]")):
        yield "without code, the prepared pictures cannot be chosen"

    levels = Panel.of_slider(driver, "level (m)")
    panel.write(PRINTING)
    for key, level in ((Keys.ARROW_RIGHT, "-1.1"), (Keys.HOME, "-2.2"), (Keys.END, "0.6")):
        end = levels.move(key)
        if end != f"Computed with level={level}." or f"a level of {level}" not in levels.outputs():
            yield f"a slider at {level} says: {end} {levels.outputs()}"
        if levels.shown_pictures() != [f"The figure with level={level}."]:
            yield f"a slider at {level} shows {levels.shown_pictures()}"
    if any(button.is_displayed() for button in levels.find("input[type=radio]")):
        yield "a computed picture is below buttons that do not belong to it"
    boxes = {"slider_written": levels.box, "slider_not_written": cells.box}
    yield from faults_in_views(driver, boxes, axe, pictures)


def faults_of_lesson(driver, root, path):
    """Check each exercise of a lesson with the lesson's own solution; yield faults."""
    solved = json.loads((PROJECT / "solutions" / path).with_suffix(".ipynb").read_text("utf-8"))
    exercises = [
        cell
        for cell in solved["cells"]
        if cell["cell_type"] == "code" and cell["metadata"].get("nbgrader", {}).get("solution")
    ]
    pasted = [cell for cell in solved["cells"] if "earlier" in cell["metadata"].get("tags", ())]
    sources = {cell["id"]: "".join(cell["source"]) for cell in (*pasted, *exercises)}
    driver.get(f"{root}{path}.html")
    store = (
        "for (const [key, text] of Object.entries(arguments[0])) localStorage.setItem(key, text)"
    )
    name = path.rpartition("/")[2]
    driver.execute_script(store, {f"code-{name}-{id}": text for id, text in sources.items()})
    driver.get(f"{root}{path}.html")
    for cell in exercises:
        id = cell["id"]
        panel = Panel(driver, id)
        panel.open()
        if not panel.find("button.check"):
            continue
        end = panel.run("check")
        if end != "Checked." or "passed" not in panel.outputs() or "failed" in panel.outputs():
            yield f"{id}: {end} {panel.outputs()}"


def main(site, python, axe, pictures, lessons):
    """Print each fault as soon as it is found, and return all faults."""
    pictures.mkdir(parents=True, exist_ok=True)
    handler = functools.partial(_QuietHandler, directory=str(site))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    root = f"http://127.0.0.1:{server.server_port}/"
    found, driver = [], browser()
    try:
        with tempfile.TemporaryDirectory() as folder:
            setting = {"behavior": "allow", "downloadPath": folder}
            driver.execute_cdp_cmd("Browser.setDownloadBehavior", setting)
            driver.execute_cdp_cmd("Network.enable", {})
            view(driver, 1280, "light")
            for lesson in lessons:
                (page,) = site.glob(f"*/{lesson}.html")
                path = page.relative_to(site).with_suffix("").as_posix()
                if lesson == LESSON:
                    faults = faults_of_solving(driver, root, python, axe, pictures, Path(folder))
                else:
                    faults = faults_of_lesson(driver, root, path)
                for fault in faults:
                    found.append(f"{lesson}: {fault}")
                    print(found[-1], flush=True)
        addresses = on_other_hosts(requested_addresses(driver)[0])
        # OTHER_HOST requests this address, to show that the page's policy refuses it.
        found += [
            f"requests {address}" for address in addresses if address != "https://example.org/"
        ]
    finally:
        driver.quit()
        server.shutdown()
    return found


if __name__ == "__main__":
    place, interpreter, script, folder, *names = sys.argv[1:]
    wrong = main(
        Path(place), interpreter, Path(script).read_text("utf-8"), Path(folder), names or [LESSON]
    )
    print("\n".join(wrong) or "No faults.")
    sys.exit(bool(wrong))
