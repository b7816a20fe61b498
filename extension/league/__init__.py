"""A league in which students' detectors drive as far as they can. It never affects a mark.

`streets` draws the streets, `drives` drives one street with one detector in a sandbox, and
`season` drives a class through all of them. `ranking` counts the metres, and `page` shows the
result under `pseudonyms`.
"""
