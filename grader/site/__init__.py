"""The course as pages: text, stubs, and the pictures that one should get, without a kernel."""
