"""Check a built site in a browser, offline; `.ci/site` runs this script, not pytest.

    python -m tests.site_in_browser SITE PYTHON AXE.js PICTURES

Every page is opened in four views. No page may load anything from another host, scroll sideways,
have broken pictures or lines, load too much before scrolling, or have faults that axe-core finds.
Then the script acts as a reader. It searches, enters a guess, moves a slider and chooses the dark
theme, with and without a server. On the front page, the playground must move, follow its sliders
and find the same clusters as SciPy. Without WebGL, the film must replace it. An address must show
what the reader saw who sends it. PYTHON is an interpreter with the course's packages.
"""

import base64
import functools
import http.server
import json
import re
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path
from urllib.parse import parse_qsl, urlencode, urlsplit

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

VIEWS = ((390, "light"), (768, "light"), (1200, "dark"), (1600, "light"))
HEIGHT = 900
HEAVIEST = 3_000_000  # bytes, before scrolling
HEAVIEST_SCENE = 1_500_000  # bytes, which load when the scene comes into view
PATIENCE = 600  # seconds, on a machine with other work
SWITCHES = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-quic"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--no-first-run", "--enable-unsafe-swiftshader"),  # WebGL without a graphics card
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
)
BROKEN_IMAGES = """
return [...document.images].filter((image) => image.complete && !image.naturalWidth)
  .map((image) => image.src)
"""
BROKEN_LINES = """
const parted = [...document.querySelectorAll('span.math')].filter((formula) => {
  const mark = formula.nextSibling;
  if (mark?.nodeType !== Node.TEXT_NODE || !/^[.,;:?!)]/.test(mark.data)) return false;
  const place = document.createRange();
  place.setStart(mark, 0);
  place.setEnd(mark, 1);
  return place.getBoundingClientRect().top >= formula.getBoundingClientRect().bottom;
});
const names = [...document.querySelectorAll('.bd-article code.literal .pre')].filter(
  (name) => name.textContent.length < 16 && name.getClientRects().length > 1);
return [...parted, ...names].map((part) => part.parentElement.innerText.slice(0, 60));
"""
WAIT_UNTIL_SETTLED = """
const done = arguments[arguments.length - 1];
Promise.resolve(window.MathJax?.startup?.promise).then(() => setTimeout(done, 300));
"""
AXE = """
const done = arguments[arguments.length - 1];
axe.run(document, {iframes: false}).then(({violations}) => done(violations.map(
  ({id, nodes}) => `${id} (${nodes.length}): ${nodes[0].target} ${nodes[0].failureSummary}`)));
"""
ICON_AND_TEXT = """
const field = document.querySelector('.bd-search-container form.bd-search');
const input = field.querySelector('input'), icon = field.querySelector('.fa-magnifying-glass');
const start = input.getBoundingClientRect().left + parseFloat(getComputedStyle(input).paddingLeft);
return [start, icon.getBoundingClientRect().right];
"""
PROJECT = Path(__file__).parent.parent
DISTINCT_COLOURS = """
const [picture, done] = arguments, image = new Image();
image.onload = () => {
  const canvas = document.createElement("canvas"), context = canvas.getContext("2d");
  [canvas.width, canvas.height] = [image.width, image.height];
  context.drawImage(image, 0, 0);
  const {data} = context.getImageData(0, 0, image.width, image.height);
  done(new Set(new Uint32Array(data.buffer)).size);
};
image.src = `data:image/png;base64,${picture}`;
"""
MOVE_SLIDERS = """
const {elements} = document.querySelector("figure.playground form");
for (const [name, value] of Object.entries(arguments[0])) elements[name].value = value;
elements.ground.dispatchEvent(new Event("input", {bubbles: true}));
"""
HEADING = -2.3  # radians, of the playground's first view
SLIDERS = {"ground": 0.2, "distance": 25, "threshold": 0.3, "least": 20}
PICTURES_OF_SCENES = """
const pictures = [...document.querySelectorAll('div.still img')];
return pictures.length && pictures.every((image) => image.naturalWidth);
"""
ON_PAPER = """
const shown = (selector) =>
  [...document.querySelectorAll(selector)].filter((element) => element.offsetHeight);
return [
  shown('iframe.scene').length,
  document.querySelectorAll('iframe.scene').length,
  shown('div.still img').length,
  shown('.bd-article pre').filter((block) => block.scrollWidth > block.clientWidth + 1)
    .map((block) => block.innerText.slice(0, 40)),
];
"""
SHOW_ALL = "for (const block of document.querySelectorAll('details')) block.open = true"


class _QuietHandler(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *about):
        pass

    def send_error(self, code, message=None, explain=None):
        """Show the site's page at missing addresses, as GitHub Pages does."""
        page = Path(self.directory) / "404.html"
        if code != http.HTTPStatus.NOT_FOUND:
            super().send_error(code, message, explain)
            return
        self.send_response(code)
        self.send_header("Content-Type", "text/html")
        self.send_header("Content-Length", str(page.stat().st_size))
        self.end_headers()
        if self.command == "GET":
            self.wfile.write(page.read_bytes())


def browser(*switches):
    """Start a Chromium that can reach only this machine."""
    options = webdriver.ChromeOptions()
    for switch in (*SWITCHES, *switches):
        options.add_argument(switch)
    options.binary_location = next(
        filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome")))
    )
    options.set_capability("goog:loggingPrefs", {"performance": "ALL", "browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    driver.command_executor.client_config.timeout = PATIENCE
    driver.set_page_load_timeout(PATIENCE)
    driver.set_script_timeout(PATIENCE)
    return driver


def view(driver, width, theme, motion="no-preference"):
    """Set the width of the page, the preferred theme (light or dark) and the preferred motion."""
    size = {"width": width, "height": HEIGHT, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    preferred = {"prefers-color-scheme": theme, "prefers-reduced-motion": motion}
    features = [{"name": name, "value": value} for name, value in preferred.items()]
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})


def requested_addresses(driver):
    """Return the addresses and total bytes of all requests since the last call."""
    addresses, weight = [], 0
    for entry in driver.get_log("performance"):
        message = json.loads(entry["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            addresses.append(message["params"]["request"]["url"])
        elif message["method"] == "Network.loadingFinished":
            weight += message["params"]["encodedDataLength"]
    return addresses, weight


def on_other_hosts(addresses):
    """Return the addresses on other hosts."""
    return [
        address
        for address in addresses
        if urlsplit(address).scheme in ("http", "https", "ws", "wss")
        and urlsplit(address).hostname != "127.0.0.1"
    ]


def faults_of_page(driver, address, axe):
    """Yield the faults of a page in the current view."""
    driver.execute_cdp_cmd("Network.enable", {})
    driver.execute_cdp_cmd("Network.setCacheDisabled", {"cacheDisabled": True})
    requested_addresses(driver)
    driver.get(address)
    driver.execute_async_script(WAIT_UNTIL_SETTLED)
    addresses, weight = requested_addresses(driver)
    if weight > HEAVIEST:
        yield f"{weight:,} bytes before scrolling"
    for other in on_other_hosts(addresses):
        yield f"requests {other}"
    across = driver.execute_script(
        "return document.documentElement.scrollWidth - document.documentElement.clientWidth"
    )
    if across > 0:
        yield f"scrolls {across} pixels sideways"
    driver.execute_script(SHOW_ALL)
    driver.execute_script("window.scrollTo(0, document.body.scrollHeight)")
    driver.execute_async_script(WAIT_UNTIL_SETTLED)
    for picture in driver.execute_script(BROKEN_IMAGES):
        yield f"has a broken picture: {picture}"
    for text in driver.execute_script(BROKEN_LINES):
        yield f"breaks a line before a comma or within a name: {text}"
    for other in on_other_hosts(requested_addresses(driver)[0]):
        yield f"requests {other}"
    driver.execute_script(axe)
    yield from driver.execute_async_script(AXE)


def search_results(driver, root, query):
    """Return (address, text) for each result that a search shows."""
    driver.get(f"{root}search.html?q={'+'.join(query.split())}")
    WebDriverWait(driver, PATIENCE).until(
        lambda page: page.find_elements(By.CSS_SELECTOR, "#search-results ul.sections li")
    )
    time.sleep(1)
    items = driver.find_elements(By.CSS_SELECTOR, "#search-results ul.sections > li")
    return [
        (item.find_element(By.TAG_NAME, "a").get_attribute("href"), item.text) for item in items
    ]


def faults_of_reading(driver, root):
    """Act as a reader; yield a sentence for each action that does not work."""
    view(driver, 1200, "light")
    hits = search_results(driver, root, "why not a smaller threshold")
    if not any("05_euclidean_clustering.html#" in link for link, _ in hits):
        yield f"a search for a smaller threshold finds only {hits}"
    if not any("lorry" in line for _, line in search_results(driver, root, "lorry sofa")):
        yield "a search does not show the text that it finds"
    first = search_results(driver, root, "corner order")[0][1]
    if not first.startswith("Eight corners in an agreed order"):
        yield f"a search for the order of corners begins with {first}"
    first = search_results(driver, root, "how many iterations")[0][1]
    if "iterations_needed" not in first.splitlines()[0]:
        yield f"a search for the number of iterations begins with {first}"
    start, end = driver.execute_script(ICON_AND_TEXT)
    if end > start:
        yield f"the icon in the search field ends at {end} pixels, and the text starts at {start}"
    driver.get(f"{root}search.html?q=thresold")
    suggested = WebDriverWait(driver, PATIENCE).until(
        lambda page: page.find_elements(By.CSS_SELECTOR, ".did-you-mean a")
    )
    if suggested[0].text != "threshold":
        yield f"a search for thresold suggests {suggested[0].text}"

    driver.get(f"{root}stage2_clustering/05_euclidean_clustering.html")
    driver.execute_async_script(WAIT_UNTIL_SETTLED)
    field = driver.find_element(By.CSS_SELECTOR, "form.guess input[type=text]")
    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", field)
    field.send_keys("41")
    driver.get(driver.current_url)
    yours = "return document.querySelector('details.answer .yours').textContent"
    if "41" not in driver.execute_script(yours):
        yield "a guess is not shown with the answer"
    progress = driver.find_element(By.CSS_SELECTOR, ".progress-so-far").text
    driver.get(f"{root}index.html")
    card = driver.find_element(By.CSS_SELECTOR, "a.lesson-card[href*='05_euclidean']").text
    if not (progress.startswith("So far: 1 of ") and "1 of " in card):
        yield f"the progress is {progress!r}, and on the card {card!r}"
    driver.back()
    driver.execute_async_script(WAIT_UNTIL_SETTLED)

    chosen = driver.find_element(By.CSS_SELECTOR, ".positions input:checked")
    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", chosen)
    seen = (
        "return [...arguments[0].closest('.positions').querySelectorAll('.position')]"
        ".map(p => p.offsetHeight > 0)"
    )
    before = driver.execute_script(seen, chosen)
    chosen.send_keys(Keys.ARROW_RIGHT)
    after = driver.execute_script(seen, chosen)
    if sum(before) != 1 or sum(after) != 1 or before == after:
        yield f"an arrow key does not move the slider: {before}, {after}"

    driver.execute_script("window.scrollTo(0, 0)")
    driver.find_element(By.CSS_SELECTOR, ".theme-switch-button").click()
    driver.find_element(By.CSS_SELECTOR, ".theme-change-button[data-mode=dark]").click()
    if driver.execute_script("return document.documentElement.dataset.theme") != "dark":
        yield "the switch between light and dark does nothing"


def playground_of(driver, root):
    """Open the front page and return the playground's canvas, when its first result is there."""
    driver.get(f"{root}index.html")
    WebDriverWait(driver, PATIENCE).until(
        lambda page: page.find_elements(By.CSS_SELECTOR, "figure.playground[data-plane]")
    )
    return driver.find_element(By.CSS_SELECTOR, "figure.playground canvas")


def counts_after(driver, text):
    """Return the text with the playground's counts, when it differs from `text`."""
    shown = (By.CSS_SELECTOR, "figure.playground .counts")
    WebDriverWait(driver, PATIENCE).until(lambda page: page.find_element(*shown).text != text)
    return driver.find_element(*shown).text


def faults_of_playground(driver, root, site, python):
    """Play with the scan on the front page; yield a sentence for each fault."""
    view(driver, 1200, "light")
    driver.execute_cdp_cmd("Network.enable", {})
    driver.execute_cdp_cmd("Network.setCacheDisabled", {"cacheDisabled": True})
    requested_addresses(driver)
    canvas = playground_of(driver, root)
    addresses, weight = requested_addresses(driver)
    if weight > HEAVIEST:
        yield f"the front page and its scan weigh {weight:,} bytes"
    for other in on_other_hosts(addresses):
        yield f"the playground requests {other}"
    picture = canvas.screenshot_as_base64
    time.sleep(2)
    if canvas.screenshot_as_base64 == picture:
        yield "the scan does not move by itself"

    view(driver, 1200, "light", "reduce")
    canvas = playground_of(driver, root)
    text = counts_after(driver, "Loading the scan")
    picture = canvas.screenshot_as_base64
    colours = driver.execute_async_script(DISTINCT_COLOURS, picture)
    if colours < 50:
        yield f"the picture of the scan has only {colours} colours"
    time.sleep(7)  # longer than a stage
    if canvas.screenshot_as_base64 != picture:
        yield "the scan moves although the reader prefers reduced motion"
    canvas.send_keys(Keys.ARROW_LEFT)
    time.sleep(2)
    if canvas.screenshot_as_base64 == picture:
        yield "the left arrow key does not turn the scan"

    driver.execute_script(MOVE_SLIDERS, SLIDERS)
    text = counts_after(driver, text)
    figure = driver.find_element(By.CSS_SELECTOR, "figure.playground")
    plane = [float(number) for number in figure.get_attribute("data-plane").split()]
    script, settings = site / figure.get_attribute("data-scan"), {**SLIDERS, "plane": plane}
    command = [python, "-m", "tests.playground_oracle", script.resolve(), json.dumps(settings)]
    counted = subprocess.run(command, cwd=PROJECT, check=True, capture_output=True, text=True)
    expected = json.loads(counted.stdout)[2:]
    found = [int(number.replace(",", "")) for number in re.findall(r"[\d,]*\d", text)][:2]
    if found != expected:
        yield f"SciPy finds {expected} points and clusters, and the playground says: {text}"


def fragment_after(driver, fragment):
    """Return the part of the page's address after #, when it differs from `fragment`."""
    WebDriverWait(driver, PATIENCE).until(
        lambda page: urlsplit(page.current_url).fragment != fragment
    )
    return urlsplit(driver.current_url).fragment


def open_address(driver, address):
    """Open an address from scratch, even if the current page differs only in the fragment."""
    driver.get("about:blank")
    driver.get(address)
    driver.execute_async_script(WAIT_UNTIL_SETTLED)


def faults_of_shared_playground(driver, root):
    """Open addresses of views of the playground; yield a sentence for each fault."""
    view(driver, 1200, "light", "reduce")
    open_address(driver, f"{root}index.html")
    start = playground_of(driver, root).screenshot_as_base64
    length = driver.execute_script("return history.length")
    if urlsplit(driver.current_url).fragment:
        yield "the address of the front page changes before the reader moves anything"
    driver.execute_script(MOVE_SLIDERS, SLIDERS)
    driver.find_element(By.CSS_SELECTOR, "input[name=stage][value='3']").click()
    driver.find_element(By.CSS_SELECTOR, "figure.playground canvas").send_keys(Keys.ARROW_LEFT)
    shared = fragment_after(driver, "")
    found = dict(parse_qsl(shared))
    if not found.items() >= {name: str(value) for name, value in SLIDERS.items()}.items():
        yield f"the address of the playground has no sliders: {shared}"
    if driver.execute_script("return history.length") != length:
        yield "moving the playground adds to the browser's history"

    # A turn to the left changes the heading in an address that the playground has read.
    wrong = urlencode(found | {"height": 9})
    text = driver.find_element(By.CSS_SELECTOR, "figure.playground .counts").text
    for sent, read in ((shared, True), (wrong, False), (f"{shared}x", False)):
        open_address(driver, f"{root}index.html#{sent}")
        canvas = driver.find_element(By.CSS_SELECTOR, "figure.playground canvas")
        counts = counts_after(driver, "Loading the scan")
        time.sleep(2)  # until the points have their colours
        if (canvas.screenshot_as_base64 == start) == read or (counts == text) != read:
            yield f"the playground shows {counts!r} at #{sent}"
        canvas.send_keys(Keys.ARROW_LEFT)
        turned = float(dict(parse_qsl(fragment_after(driver, sent)))["heading"])
        before = float(found["heading"]) if read else HEADING
        if abs(turned - before - 0.1) > 0.001:
            yield f"after a turn by 0.1 to the left, the heading at #{sent} is {turned}"
    open_address(driver, f"{root}index.html#for-instructors")
    if not driver.execute_script("return scrollY"):
        yield "the address of a heading does not lead to the heading"


def faults_of_shared_scene(driver, root):
    """Open addresses of views of a lesson's scene; yield a sentence for each fault."""
    view(driver, 1200, "light")
    page = f"{root}stage2_clustering/05_euclidean_clustering.html"

    def camera(*keys):
        """Press keys in the scene, and return its camera."""
        frame = driver.find_element(By.CSS_SELECTOR, "iframe.scene")
        driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", frame)
        driver.switch_to.frame(frame)
        canvas = WebDriverWait(driver, PATIENCE).until(
            lambda scene: scene.find_element(By.TAG_NAME, "canvas")
        )
        driver.execute_async_script("setTimeout(arguments[0], 1000)")
        if keys:
            canvas.send_keys(*keys)
        text = driver.execute_script("return cameraText()")
        driver.switch_to.default_content()
        return text

    open_address(driver, page)
    start, length = camera(), driver.execute_script("return history.length")
    if urlsplit(driver.current_url).fragment:
        yield "the address of a lesson changes before the reader moves a scene"
    moved = camera(Keys.ARROW_LEFT, "+", Keys.SHIFT + Keys.ARROW_UP)
    shared = fragment_after(driver, "")
    if moved == start or shared != f"scene-1={moved}":
        yield f"the scene has the camera {moved}, and the address {shared}"
    if driver.execute_script("return history.length") != length:
        yield "moving a scene adds to the browser's history"
    open_address(driver, f"{page}#{shared}")
    place = driver.execute_script(
        "return document.querySelector('iframe.scene').getBoundingClientRect().top"
    )
    if not 0 <= place < HEIGHT or camera() != moved:
        yield f"#{shared} shows {camera()}, {place} pixels below the upper edge"
    for wrong in ("scene-1=1,2", f"scene-9={moved}", "scene-1=0,0,0,0,0,0,0,0,1,0.8"):
        open_address(driver, f"{page}#{wrong}")
        if camera() != start:
            yield f"the wrong address #{wrong} shows {camera()}"


def faults_of_scenes(site):
    """Yield a sentence for each scene that lacks points or is too heavy."""
    scenes = [
        path
        for path in site.glob("_static/shown/*.html")
        if 'id="scene"' in path.read_text("utf-8")
    ]
    if not scenes:
        yield "the site has no scenes"
    for path in scenes:
        if '"note":""' not in path.read_text("utf-8"):
            yield f"the scene {path.name} does not have all points"
        if path.stat().st_size > HEAVIEST_SCENE:
            yield f"the scene {path.name} weighs {path.stat().st_size:,} bytes"


def faults_without_webgl(driver, root):
    """Open the front page in a browser without WebGL; yield a sentence if it shows no film."""
    view(driver, 1200, "light")
    driver.get(f"{root}index.html")
    for scripts in ("with", "without"):
        without = {"value": scripts == "without"}
        driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", without)
        driver.get(f"{root}index.html")
        time.sleep(2)
        films = driver.find_elements(By.CSS_SELECTOR, "figure.film img")
        panels = driver.find_elements(By.CSS_SELECTOR, "figure.playground")
        if (
            not films
            or not films[0].size["height"]
            or any(panel.size["height"] for panel in panels)
        ):
            yield f"{scripts} scripts, the front page without WebGL does not show the film alone"


def faults_of_missing_page(driver, root):
    """Yield a sentence if the page for a missing address does not lead back to the front page."""
    driver.get(f"{root}stage9/lost.html")
    link = WebDriverWait(driver, PATIENCE).until(
        lambda page: page.find_element(By.CSS_SELECTOR, "a#start[href]")
    )
    if link.get_attribute("href") != root or not link.is_displayed():
        yield f"a missing page links to {link.get_attribute('href')}"


def faults_of_copying(driver, root):
    """Yield a sentence if the button next to code does not copy the code."""
    driver.get(f"{root}instructors.html")
    rights = {"permissions": ["clipboardReadWrite", "clipboardSanitizedWrite"], "origin": root}
    driver.execute_cdp_cmd("Browser.grantPermissions", rights)
    driver.find_element(By.CSS_SELECTOR, "button.copy").send_keys(Keys.ENTER)
    time.sleep(1)
    copied = driver.execute_async_script("navigator.clipboard.readText().then(arguments[0])")
    if copied.strip() != "make demo":
        yield f"the button copies {copied!r}"


def faults_of_film(driver, root):
    """Play the film of a lesson; yield a sentence if it does not play, or loads too early."""
    requested_addresses(driver)
    driver.get(f"{root}stage3_obstacles/09_filter_clusters.html")
    film = driver.find_element(By.CSS_SELECTOR, "figure.lesson-film video")
    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", film)
    driver.execute_async_script(WAIT_UNTIL_SETTLED)
    if [address for address in requested_addresses(driver)[0] if address.endswith(".mp4")]:
        yield "a film loads before a reader plays it"
    driver.execute_script("arguments[0].play()", film)
    state = "return [arguments[0].error?.message ?? '', arguments[0].currentTime]"
    error, _ = WebDriverWait(driver, PATIENCE).until(
        lambda page: next((s for s in [page.execute_script(state, film)] if s[0] or s[1] > 0), None)
    )
    if error:
        yield f"a film does not play: {error}"


def faults_on_paper(driver, root, pictures):
    """Print a lesson with a scene to PDF; yield a sentence for each part that is missing or cut."""
    driver.get(f"{root}stage2_clustering/05_euclidean_clustering.html")
    driver.execute_async_script(WAIT_UNTIL_SETTLED)
    driver.execute_cdp_cmd("Page.printToPDF", {})  # begins to load pictures that are far below
    WebDriverWait(driver, PATIENCE).until(lambda page: page.execute_script(PICTURES_OF_SCENES))
    printed = driver.execute_cdp_cmd("Page.printToPDF", {})["data"]
    (pictures / "lesson.pdf").write_bytes(base64.b64decode(printed))
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    scenes, all_scenes, stills, cut = driver.execute_script(ON_PAPER)
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    if scenes or stills != all_scenes or not stills:
        yield f"paper shows {scenes} scenes and {stills} pictures of {all_scenes} scenes"
    if cut:
        yield f"paper cuts code: {cut}"


def main(site, python, axe, pictures):
    """Print each fault as soon as it is found, and return all faults."""
    pictures.mkdir(parents=True, exist_ok=True)
    handler = functools.partial(_QuietHandler, directory=str(site))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    root = f"http://127.0.0.1:{server.server_port}/"
    names = sorted(
        path.relative_to(site).as_posix()
        for path in site.rglob("*.html")
        if "_static" not in path.parts
    )
    found = []
    driver = browser()
    try:
        for width, theme in VIEWS:
            view(driver, width, theme)
            for name in names:
                for fault in faults_of_page(driver, root + name, axe):
                    found.append(f"{name}, {width} pixels, {theme}: {fault}")
                    print(found[-1], flush=True)
                driver.execute_script("window.scrollTo(0, 0)")
                driver.save_screenshot(str(pictures / f"{width}_{Path(name).stem}.png"))
            print(f"{len(names)} pages checked at {width} pixels, {theme}", flush=True)
        for place in (root, f"{site.resolve().as_uri()}/"):
            for fault in faults_of_reading(driver, place):
                found.append(f"{place}: {fault}")
                print(found[-1], flush=True)
            for fault in faults_of_playground(driver, place, site, python):
                found.append(f"{place}: {fault}")
                print(found[-1], flush=True)
        view(driver, 800, "light")
        for fault in (
            *faults_of_missing_page(driver, root),
            *faults_of_copying(driver, root),
            *faults_of_film(driver, root),
            *faults_of_shared_playground(driver, root),
            *faults_of_shared_scene(driver, root),
            *faults_of_scenes(site),
            *faults_on_paper(driver, root, pictures),
        ):
            found.append(fault)
            print(found[-1], flush=True)
    finally:
        driver.quit()
    driver = browser("--disable-3d-apis")
    try:
        for fault in faults_without_webgl(driver, root):
            found.append(fault)
            print(fault, flush=True)
    finally:
        driver.quit()
        server.shutdown()
    return found


if __name__ == "__main__":
    place, interpreter, script, folder = sys.argv[1:]
    wrong = main(Path(place), interpreter, Path(script).read_text("utf-8"), Path(folder))
    print(f"{len(wrong)} faults" if wrong else "No faults.")
    sys.exit(bool(wrong))
