"""What keeps a site from being written."""


class SiteTrouble(Exception):
    """Nothing was written; `str()` is the sentence to show."""
