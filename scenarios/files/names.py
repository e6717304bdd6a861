"""The names of files by which a folder tells what made it."""

RESULTS = "results.json"  # of `calot run` and of `calot evaluate`
MANIFEST = "evaluation.json"  # of `calot evaluate` only
