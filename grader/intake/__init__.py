"""Read and repair submitted files, which are untrusted."""
