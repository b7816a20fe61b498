"""Judge submissions. The process that runs a student's code never decides about points."""
