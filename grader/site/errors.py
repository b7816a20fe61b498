"""Errors of the website builder."""


class SiteError(Exception):
    """The site was not written; `str()` is the message to show."""
