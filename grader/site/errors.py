"""The exception of the website builder, in its own module to avoid circular imports."""


class SiteError(Exception):
    """The site was not written; `str()` is the message to show."""
