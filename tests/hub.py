"""Run a stage on a JupyterHub in a browser, from release to feedback; `.ci/hub` starts it.

The commands for the hub, the exchange and the instructor are those in
docs/platforms/jupyterhub.md.
"""

import contextlib
import json
import os
import re
import secrets
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

import nbformat
from selenium import webdriver
from selenium.common.exceptions import WebDriverException
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

PROJECT = Path(__file__).resolve().parents[1]
STAGE, LESSON = "stage3_obstacles", "07_filter_by_distance"
EXERCISES = ("filter_by_distance", "crop_region", "remove_ego_returns")
POINTS = 30  # maximum for the lesson
STUDENTS = ("ada", "ben")
PATIENCE = 240  # seconds to wait for each element or state
# With these settings, JupyterLab draws all cells, even outside the screen, and asks no questions.
SETTINGS = {
    "@jupyterlab/notebook-extension:tracker": {"windowingMode": "none"},
    "@jupyterlab/apputils-extension:notification": {"fetchNews": "false"},
}
COURSE = Path("/home/instructor/course")
EXCHANGE = Path("/srv/exchange/lidar_obstacle_lab")


# ---- accounts and commands ----------------------------------------------------------------------


def shell_blocks():
    """Return the page's blocks of shell commands, by their first comment."""
    text = (PROJECT / "docs" / "platforms" / "jupyterhub.md").read_text("utf-8")
    found = re.findall(r"^```sh\n# (\w+(?: \w+)*)(.*?)^```", text, re.M | re.S)
    return {start: "#" + rest for start, rest in found}


def run_as(name, script, check=True, **variables):
    """Run shell commands as a user in the user's home, with the hub's programs on PATH."""
    command = [
        *("runuser", "-u", name, "--", "env", "-i", f"HOME={home(name)}", f"USER={name}"),
        *("LANG=C.UTF-8", "PATH=/srv/hub/bin:/usr/local/bin:/usr/bin:/bin"),
        *(f"{key}={value}" for key, value in variables.items()),
        *("bash", "-euc", script),
    ]
    done = subprocess.run(
        command, cwd=home(name), text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    print(f"\n== {name}: {script.strip()}\n{done.stdout.rstrip()}", flush=True)
    if check:
        assert done.returncode == 0, f"exit status {done.returncode}"
    return done


def home(name):
    """Return the home directory of a user."""
    return "/root" if name == "root" else f"/home/{name}"


def make_accounts():
    """Create accounts on this machine, and return the passwords by user name."""
    passwords = {name: secrets.token_urlsafe(12) for name in (*STUDENTS, "instructor")}
    for name in passwords:
        command = ["useradd", "--create-home", "--key", "HOME_MODE=0700", "--shell", "/bin/bash"]
        subprocess.run([*command, name], check=True)
    lines = "".join(f"{name}:{word}\n" for name, word in passwords.items())
    subprocess.run(["chpasswd"], input=lines, text=True, check=True)
    return passwords


@contextlib.contextmanager
def hub():
    """Run a hub and yield its address; print the end of its log on failure."""
    ports = [free_port() for _ in range(3)]
    log = Path("/srv/jupyterhub/log")
    command = [
        "jupyterhub",
        f"--JupyterHub.bind_url=http://127.0.0.1:{ports[0]}",
        f"--JupyterHub.hub_port={ports[1]}",
        f"--ConfigurableHTTPProxy.api_url=http://127.0.0.1:{ports[2]}",
    ]
    with log.open("w") as file:
        process = subprocess.Popen(command, cwd=log.parent, stdout=file, stderr=file)
        try:
            address = f"http://127.0.0.1:{ports[0]}"
            wait_for(f"{address}/hub/health")
            yield address
        except BaseException:
            print(f"\n== The end of the hub's log\n{log.read_text()[-6000:]}", flush=True)
            raise
        finally:
            process.send_signal(signal.SIGTERM)
            process.wait(60)


def wait_for(address):
    """Wait until a server answers at an address."""
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            urllib.request.urlopen(address, timeout=PATIENCE).close()
            return
        except OSError:
            if time.monotonic() > deadline:
                raise
            time.sleep(1)


def free_port():
    """Return a free port."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


# ---- the browser --------------------------------------------------------------------------------


class UserSession:
    """A user who is logged in to the hub with a browser."""

    def __init__(self, address, name, password, pictures):
        self.address, self.name, self.password = address, name, password
        self.pictures = pictures
        options = webdriver.ChromeOptions()
        for flag in (
            *("headless=new", "no-sandbox", "disable-gpu", "disable-quic", "no-first-run"),
            *("disable-background-networking", "disable-component-update", "disable-sync"),
            *("disable-dev-shm-usage", "window-size=1280,1000"),
            f"user-data-dir={tempfile.mkdtemp()}",
        ):
            options.add_argument(f"--{flag}")
        self.browser = webdriver.Chrome(options, Service("/usr/bin/chromedriver"))

    def __enter__(self):
        try:
            self.log_in()
        except BaseException:
            self.__exit__(*sys.exc_info())
            raise
        return self

    def log_in(self):
        """Log in with a name and a password, and wait for the user's own server."""
        self.open("/hub/login", until="#username_input")
        self.picture("login")
        self.find("#username_input").send_keys(self.name)
        self.find("#password_input").send_keys(self.password + Keys.ENTER)
        self.wait(lambda: f"/user/{self.name}/" in self.browser.current_url, "the user's server")
        self.open(f"/user/{self.name}/lab", until=".lm-MenuBar-itemLabel")

    def __exit__(self, kind, error, trace):
        if error is not None:
            self.picture("when_it_failed")
        self.browser.quit()

    def open(self, path, until):
        """Open a path of the hub, and wait for an element on the page."""
        self.browser.get(self.address + path)
        self.wait(lambda: self.browser.find_elements(By.CSS_SELECTOR, until), until)

    def find(self, selector):
        """Return the first element that matches a CSS selector."""
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def wait(self, condition, description):
        """Wait until `condition()` is true, and return its value."""

        def is_true(browser):
            with contextlib.suppress(WebDriverException):  # the page may have redrawn the element
                return condition()

        return WebDriverWait(self.browser, PATIENCE).until(
            is_true, f"{self.name} waits for {description}"
        )

    def text(self, selector):
        """Return the text of an element, even if it is not visible."""
        return self.find(selector).get_property("textContent")

    def click(self, selector, label):
        """Wait for an element with this text, and click on it."""

        def clicked():
            for element in self.browser.find_elements(By.CSS_SELECTOR, selector):
                if element.text.strip() == label:
                    element.click()
                    return True
            return False

        self.wait(clicked, f"{label!r} to click on")

    def picture(self, name):
        """Save a screenshot."""
        self.browser.save_screenshot(str(self.pictures / f"{self.name}_{name}.png"))

    # Actions in JupyterLab and nbgrader.

    def choose(self, menu, entry):
        """Choose an entry from a menu."""
        self.click(".lm-MenuBar-itemLabel", menu)
        self.click(".lm-Menu-itemLabel", entry)

    def assignments(self):
        """Open nbgrader's list of assignments."""
        self.choose("Nbgrader", "Assignment List")
        self.wait_until_listed("released", "")

    def wait_until_listed(self, kind, label):
        """Wait until a section of the list of assignments shows a text."""
        selector = f"#{kind}_assignments_list"
        self.wait(lambda: label in self.text(selector), f"{label!r} under {kind}")

    def press(self, kind, label):
        """Click a button in a section of the list of assignments."""
        self.click(f"#{kind}_assignments_list button", label)

    def notebook(self, path):
        """Open a notebook and wait until its kernel is idle."""
        self.open(f"/user/{self.name}/lab/tree/{path}", until=".jp-Notebook .jp-CodeCell")
        self.wait_until_idle()

    def wait_until_idle(self):
        """Wait until the kernel is idle and no cell is queued."""
        prompts = "return [...document.querySelectorAll('.jp-InputPrompt')].map(p => p.innerText)"
        state = ".jp-Notebook-ExecutionIndicator"
        self.wait(
            lambda: (
                self.find(state).get_attribute("data-status") == "idle"
                and "[*]:" not in self.browser.execute_script(prompts)
            ),
            "an idle kernel",
        )

    def cell(self, text):
        """Scroll to the first code cell that contains a text, and return the cell."""

        def shown():
            for cell in self.browser.find_elements(By.CSS_SELECTOR, ".jp-CodeCell"):
                if text in cell.get_property("textContent"):
                    scroll = "arguments[0].scrollIntoView({block: 'center'})"
                    self.browser.execute_script(scroll, cell)
                    return cell
            return None

        return self.wait(shown, f"a cell with {text!r}")

    def write(self, text, source):
        """Replace the source of a cell, as if the user pasted it."""
        cell = self.cell(text)
        self.wait(lambda: cell.find_element(By.CSS_SELECTOR, ".cm-content").click() is None, text)
        keys = webdriver.ActionChains(self.browser)
        keys.key_down(Keys.CONTROL).send_keys("a").key_up(Keys.CONTROL).perform()
        self.browser.execute_cdp_cmd("Input.insertText", {"text": source})

    def save_and_wait(self, path, texts):
        """Save, and wait until the file contains all the texts."""
        self.choose("File", "Save Notebook")
        file = Path(f"/home/{self.name}") / path
        saved = f"{texts} in {path}"
        self.wait(lambda: all(word in file.read_text("utf-8") for word in texts), saved)


# ---- the scenario -------------------------------------------------------------------------------


def answers():
    """Return the solution's source for each cell that students fill in."""
    solved = nbformat.read(PROJECT / "solutions" / STAGE / f"{LESSON}.ipynb", as_version=4)
    graded = [cell for cell in solved.cells if "nbgrader" in cell.metadata]
    cells = {cell.metadata.nbgrader.grade_id: cell.source for cell in graded}
    marks = re.compile(r"^ *### (BEGIN|END) SOLUTION\n?", re.M)
    return {name: marks.sub("", cells[name]).rstrip() for name in EXERCISES}


def work(session, answers):
    """Fetch the stage, run the first cell, write the answers, run all cells and submit."""
    path = f"{STAGE}/{LESSON}.ipynb"
    session.assignments()
    session.wait_until_listed("released", STAGE)
    session.press("released", "Fetch")
    session.wait_until_listed("fetched", STAGE)
    session.picture("fetched")
    session.notebook(path)
    session.cell("Run this cell first").click()
    session.choose("Run", "Run Selected Cell")
    message = "Everything this notebook needs is here."
    session.wait(lambda: message in session.text(".jp-Notebook .jp-OutputArea"), message)
    session.wait_until_idle()
    session.picture("first_cell")
    for name, source in answers.items():
        session.write(f"def {name}(", source)
    if answers:
        session.choose("Run", "Run All Cells")
        session.wait(
            lambda: session.browser.find_elements(By.CSS_SELECTOR, ".jp-OutputArea img"), "a plot"
        )
        session.wait_until_idle()
        session.cell(f"check({EXERCISES[0]})")
        session.picture("checked")
    written_last = [source.splitlines()[-1].strip() for source in answers.values()]
    session.save_and_wait(path, (message, *written_last))
    session.assignments()
    session.press("fetched", "Submit")
    session.wait_until_listed("submitted", STAGE)
    session.picture("submitted")


def look_at_feedback(session):
    """Fetch the feedback from the list, open the lesson's page and return its text."""
    session.assignments()
    session.wait_until_listed("submitted", STAGE)
    session.press("submitted", "Fetch Feedback")
    session.wait_until_listed("submitted", "(view feedback)")
    session.picture("feedback_listed")
    pages = list(Path(f"/home/{session.name}/{STAGE}/feedback").glob(f"*/{LESSON}.html"))
    assert len(pages) == 1, pages
    page = pages[0].relative_to(f"/home/{session.name}")
    session.open(f"/user/{session.name}/files/{page}", until="#toc, body h1, body h4")
    session.picture("feedback")
    return session.text("body")


def check_permissions():
    """Assert that the instructor can read secret files and a student cannot."""
    secret = [
        f"cat {COURSE}/.course_seed",
        f"cat {COURSE}/gradebook.db",
        f"ls {COURSE}/solutions/stage3_obstacles/06_filter_ground",
        f"ls {COURSE}/submitted/ada",
        f"ls {EXCHANGE}/inbound",
        f"ls {EXCHANGE}/feedback",
    ]
    for command in secret:
        quietly = f"{command} > ~/out"
        assert run_as("instructor", quietly, check=False).returncode == 0
        assert run_as("ben", quietly, check=False).returncode != 0
    for command in (f"mv {EXCHANGE} {EXCHANGE}.mine", f"touch {EXCHANGE}/outbound/{STAGE}/x"):
        assert run_as("ben", command, check=False).returncode != 0
    assert run_as("ben", f"ls /home/ada/{STAGE}", check=False).returncode != 0


def scores():
    """Return the points in nbgrader's gradebook by (student, lesson)."""
    query = """
        SELECT submitted_assignment.student_id, notebook.name, SUM(grade.auto_score)
        FROM grade JOIN submitted_notebook ON grade.notebook_id = submitted_notebook.id
        JOIN submitted_assignment ON submitted_notebook.assignment_id = submitted_assignment.id
        JOIN notebook ON submitted_notebook.notebook_id = notebook.id
        GROUP BY submitted_assignment.student_id, notebook.name
    """
    with contextlib.closing(sqlite3.connect(COURSE / "gradebook.db")) as book:
        return {(student, lesson): points for student, lesson, points in book.execute(query)}


def run_scenario(pictures):
    """Run the whole scenario, from an empty machine to the feedback."""
    steps = shell_blocks()
    passwords = make_accounts()
    run_as("root", steps["As root"])
    run_as("instructor", steps["As the instructor"], ADDRESS="/srv/course.git")
    run_as("instructor", steps["Hand out"])
    settings = Path("/srv/hub/share/jupyter/lab/settings/overrides.json")
    settings.parent.mkdir(exist_ok=True)
    settings.write_text(json.dumps(SETTINGS), "utf-8")
    with hub() as address:

        def session(name):
            return UserSession(address, name, passwords[name], pictures)

        with session("ada") as ada:
            work(ada, answers())
        with session("ben") as ben:
            work(ben, {})
        run_as("instructor", steps["Collect"])
        check_permissions()
        found = scores()
        assert found["ada", LESSON] == POINTS, found
        assert found["ben", LESSON] == 0, found
        with session("instructor") as instructor:
            instructor.open("/user/instructor/formgrader", until="a[href*=manage_submissions], h1")
            instructor.wait(lambda: STAGE in instructor.text("body"), STAGE)
            instructor.picture("formgrader")
        with session("ada") as ada:
            assert f"{POINTS}.0 / {POINTS}.0" in look_at_feedback(ada)
        with session("ben") as ben:
            assert f"0.0 / {POINTS}.0" in look_at_feedback(ben)
    print(f"\nEverything works. The screenshots are in {pictures}")


if __name__ == "__main__":
    os.umask(0o022)
    run_scenario(Path(sys.argv[1]))
