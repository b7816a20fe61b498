"""Lessons that run in the reader's browser: Python in WebAssembly, an editor, and Run and Check.

`runtime` packs Python and its packages, `bundles` the scripts, and `files` puts both into the site.
`guest/` contains code that runs in the browser's Python, and `browser/` the scripts.
"""
