"""The course as a website: text, stubs and the expected pictures, readable without a kernel."""
