"""Grade a class: find submissions, judge them in parallel, compare them; and a sample class."""
