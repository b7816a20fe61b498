"""A class: all its submissions, the report on them, and a pretend one."""
