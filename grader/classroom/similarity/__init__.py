"""Find similar functions of a stage, and measure how unusual their similarity is in the class.

The result is not an accusation: a person has to look and ask. `normal_form` removes from a
function everything that is easily changed, `answers` extracts the functions from submissions,
`comparison` weighs their common parts, and `page` shows the result.
"""
