"""Find similar functions in a stage, and measure how unusual their similarity is in the class.

The result is not an accusation: a person must look at the answers and ask the students.
`normal_form` removes the details of a function that are easily changed, `answers` extracts the
functions from submissions, `comparison` weighs their common parts, and `page` shows the result.
"""
