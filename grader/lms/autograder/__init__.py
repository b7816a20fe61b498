"""The autograder that judges submissions on Gradescope.

`package` builds the zip on the instructor's machine. In Gradescope's container, `__main__` is the
entry point. `isolation` restricts access to tests and seed, `jails` prepares the sandbox, `judging`
judges the submission, and `results` writes Gradescope's format.
"""
