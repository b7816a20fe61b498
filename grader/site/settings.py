"""Settings of Sphinx, MyST-NB and the theme."""

from grader.course.lessons import every_lesson
from grader.course.settings import course_title, version
from grader.site.sharing import descriptions


def conf_source(live: dict[str, object] | None = None, shared_picture: str = "") -> str:
    """Return the source of Sphinx's ``conf.py``; see `settings` for the parameters."""
    return "".join(
        f"{name} = {value!r}\n" for name, value in settings(live, shared_picture).items()
    )


def settings(live: dict[str, object] | None = None, shared_picture: str = "") -> dict[str, object]:
    """Return Sphinx's settings by name.

    Parameters
    ----------
    live : dict, optional
        From `grader.site.live.files.LiveFiles.settings`, if lessons run in the browser.
    shared_picture : str, optional
        Public address of the picture that messengers show, from
        `grader.site.sharing.picture_address`.
    """
    theme = {
        "use_download_button": False,  # the button would need the sources in the site
        "use_fullscreen_button": False,
        "toc_title": "On this page",
        "search_bar_text": "Search the course",
        "search_as_you_type": False,
        "navigation_with_keys": False,
        "show_navbar_depth": 1,
        "home_page_in_toc": False,
        "back_to_top_button": False,
        "footer_content_items": ["copyright.html"],
        "pygments_light_style": "a11y-high-contrast-light",
        "pygments_dark_style": "a11y-high-contrast-dark",
    }
    return {
        "project": course_title(),
        "html_title": course_title(),
        "copyright": f"the authors of {course_title()} {version()}. "
        "Code: MIT; text and pictures: CC BY 4.0",
        "language": "en",
        "extensions": ["myst_nb"],
        "exclude_patterns": ["_static/**", "_templates/**"],
        "nb_execution_mode": "off",
        "nb_merge_streams": True,
        "myst_enable_extensions": ["dollarmath", "amsmath"],
        "myst_heading_anchors": 4,
        "templates_path": ["_templates"],
        # Sphinx's summaries need a server, so search.js shows summaries instead.
        "html_show_search_summary": False,
        "html_context": {
            "descriptions": descriptions(),
            "shared_picture": shared_picture,
            "live": live,
            "lessons": lesson_pages(),
        },
        "html_favicon": "_static/icon.svg",
        "html_theme": "sphinx_book_theme",
        "html_theme_options": theme,
        "html_sidebars": {"**": ["navbar-logo.html", "sbt-sidebar-nav.html"]},
        "html_static_path": ["_static"],
        "html_extra_path": ["extra"],
        "html_css_files": ["site.css"],
        "html_js_files": [("site.js", {"defer": "defer"})],
        "html_copy_source": False,
        "html_show_sourcelink": False,
        "html_show_sphinx": False,
        "html_use_index": False,
        "html_domain_indices": False,
        "mathjax_path": "mathjax/tex-chtml.js",
        # With the menu, the Tab key would stop at each formula.
        "mathjax3_config": {"options": {"enableMenu": False}},
    }


def lesson_pages() -> dict[str, str]:
    """Return the name of each lesson by the name of its page."""
    return {f"{lesson.stage}/{lesson.name}": lesson.name for lesson in every_lesson()}
