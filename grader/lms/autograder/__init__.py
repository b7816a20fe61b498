"""An autograder for Gradescope that judges there.

`packing` makes the zip, on the instructor's machine. What runs in Gradescope's container begins in
`__main__`: `closing` shuts others out of tests and seed, `judging` judges what was handed in, and
`results` says it in Gradescope's format.
"""
