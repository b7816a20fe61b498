"""Errors of the website builder."""


class SiteTrouble(Exception):
    """The site was not written; `str()` is the message to show."""
