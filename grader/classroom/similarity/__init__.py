"""Whose functions of a stage are alike, and how unusual that is in this class.

It accuses nobody: it says what is alike, and a person asks. `normal_form` takes from a function
what is easily changed, `answers` gets the functions out of what was handed in, `comparing` weighs
what two have in common, `page` shows it.
"""
