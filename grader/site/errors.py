"""The exception that the website builder raises."""


class SiteError(Exception):
    """The site was not written; `str()` is the message to show."""
