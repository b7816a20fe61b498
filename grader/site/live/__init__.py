"""Lessons that run in the reader's browser: Python in WebAssembly, an editor, and Run and Check.

`runtime` packs Python and its packages, `bundles` packs the scripts, and `files` adds both to the
site. ``guest/`` contains code that runs in the browser's Python, and ``browser/`` the scripts.
"""
