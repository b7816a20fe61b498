"""Open and print pages in Chromium, with the MathJax installed on this machine."""

import http.server
import os
import shutil
import subprocess
import tempfile
import threading
from pathlib import Path

import nbformat
from nbconvert.exporters import HTMLExporter

from grader.site import pdf

BROWSER = next(filter(None, map(shutil.which, pdf.BROWSERS)), None)
PDF_TO_TEXT = shutil.which("pdftotext")
# Debian's package libjs-mathjax by default. MATHJAX can name a folder with MathJax 2, or the folder
# `es5` of MathJax 3.
MATHJAX = Path(os.environ.get("MATHJAX", "/usr/share/javascript/mathjax"))
# Entry files without MathJax's safe mode; pages that are safe without it are also safe with it.
ENTRIES = ("MathJax.js?config=TeX-AMS_CHTML-full", "tex-chtml-full.js", "tex-svg-full.js")
SECONDS = 100  # virtual time that a page's scripts get
PATIENCE = 500


def _run(command, **options):
    """Run Chromium with a writable TMPDIR whose path is short enough for Chromium's lock."""
    env = {**os.environ, "TMPDIR": tempfile.gettempdir()}
    return subprocess.run(command, env=env, timeout=PATIENCE, **options)


def mathjax_entries():
    """Return the installed files from which a page can load MathJax."""
    return [entry for entry in ENTRIES if (MATHJAX / entry.split("?")[0]).is_file()]


class _Handler(http.server.SimpleHTTPRequestHandler):
    def do_GET(self):
        host, path = self.headers["Host"], self.path.split("?")[0]
        if host.startswith("127.0.0.1") and path == "/":
            self.answer(self.server.page)
        elif host.startswith("127.0.0.1") and path.startswith("/mathjax/"):
            file = MATHJAX / path.removeprefix("/mathjax/")
            self.answer(file.read_bytes() if file.is_file() else b"")
        else:
            # Chromium's own requests may be among them.
            self.server.requests.append((host, self.path))
            self.answer(b"")

    def answer(self, content):
        self.send_response(200)
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *about):
        pass


def page_of(texts, entry):
    """Return the page of a notebook as in feedback and Formgrader, but with the local MathJax."""
    cells = [nbformat.v4.new_markdown_cell(text) for text in texts]
    exporter = HTMLExporter(template_name="classic", mathjax_url=f"/mathjax/{entry}")
    page = exporter.from_notebook_node(nbformat.v4.new_notebook(cells=cells))[0]
    if "config=" not in entry:  # the template configures MathJax 2 only
        settings = "MathJax = {tex: {inlineMath: [['$', '$'], ['\\\\(', '\\\\)']]}}"
        page = page.replace("<head>", f"<head><script>{settings}</script>", 1)
    return page


def printed_lines(page, folder):
    """Print a page to PDF and return the lines on each sheet, extracted with `pdftotext`."""
    folder.mkdir()
    (folder / "page.html").write_text(page, "utf-8")
    command = [
        BROWSER,
        *("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"),
        *("--disable-background-networking", "--no-first-run", f"--user-data-dir={folder}/user"),
        *("--no-pdf-header-footer", f"--print-to-pdf={folder}/page.pdf"),
        (folder / "page.html").as_uri(),
    ]
    _run(command, capture_output=True, check=True)
    return sheets_of(folder / "page.pdf")


def sheets_of(path):
    """Return the lines on each sheet of a PDF file, extracted with `pdftotext`."""
    command = [PDF_TO_TEXT, "-layout", path, "-"]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return [sheet.split("\n") for sheet in text.split("\f")[:-1]]


def save_screenshot(address, path, width, height):
    """Save the upper part of a page as a picture with 1.5 pixels per CSS pixel."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            BROWSER,
            *("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"),
            *("--disable-background-networking", "--no-first-run", f"--user-data-dir={folder}"),
            *("--hide-scrollbars", "--force-device-scale-factor=1.5"),
            *(f"--window-size={width},{height}", f"--screenshot={path}", address),
        ]
        _run(command, capture_output=True, check=True)


def rendered_page(page, folder, elsewhere):
    """Return the page after its scripts have run, and the paths requested from other hosts."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), _Handler)
    server.page, server.requests = page.encode(), []
    threading.Thread(target=server.serve_forever, daemon=True).start()
    address = f"127.0.0.1:{server.server_port}"
    command = [
        BROWSER,
        *("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"),
        *("--disable-background-networking", "--no-first-run", f"--user-data-dir={folder}"),
        f"--host-resolver-rules=MAP * {address}, EXCLUDE 127.0.0.1",
        *(f"--virtual-time-budget={1000 * SECONDS}", "--dump-dom", f"http://{address}/"),
    ]
    try:
        done = _run(command, capture_output=True, text=True)
    finally:
        server.shutdown()
        server.server_close()
    return done.stdout, [path for host, path in server.requests if host == elsewhere]
