"""The parts of a page that a browser would act on."""

import html.parser
import re

from nbconvert.exporters import HTMLExporter

# Tags that Markdown produces from plain text.
SAFE_TAGS = {
    *("p", "h1", "h2", "h3", "h4", "h5", "h6", "em", "strong", "code", "pre", "a", "img", "ul"),
    *("ol", "li", "blockquote", "hr", "br", "del", "table", "thead", "tbody", "tr", "th", "td"),
    *("span", "div"),
}
SCHEME = re.compile(r"([a-z][a-z0-9+.-]*):")


class ActivePartCollector(html.parser.HTMLParser):
    """Collects the tags and attributes that a browser would act on."""

    def __init__(self):
        super().__init__()
        self.active_parts = []

    def handle_starttag(self, tag, attributes):
        if tag not in SAFE_TAGS:
            self.active_parts.append(tag)
        for name, value in attributes:
            address = "".join((value or "").split()).lower()
            if name.startswith("on") or name == "style" and "url(" in address:
                self.active_parts.append((tag, name))
            if tag == "img" and name == "src" and not address.startswith(("attachment:", "data:")):
                self.active_parts.append((tag, name, value))
            if name in ("href", "src", "action", "formaction", "xlink:href"):
                scheme = SCHEME.match(address)
                if scheme and scheme[1] not in ("http", "https", "mailto", "attachment"):
                    self.active_parts.append((tag, name, value))


def active_parts(page):
    collector = ActivePartCollector()
    collector.feed(page)
    return collector.active_parts


def page_of(notebook):
    return HTMLExporter(template_name="classic").from_notebook_node(notebook)[0]
