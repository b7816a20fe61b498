"""The course as a website: the text, stubs and expected outputs of each lesson."""
