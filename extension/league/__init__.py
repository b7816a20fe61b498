"""A league of simulated drives, each with one student's detector. It never affects a mark.

`streets` generates the streets, `drives` drives one street with one detector in a sandbox, and
`season` drives every street with every detector. `ranking` counts the metres, and `page` shows the
results under `pseudonyms`.
"""
