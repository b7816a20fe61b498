"""The course as a website, with text, stubs and expected pictures, readable without a kernel."""
