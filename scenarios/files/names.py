"""The names of the files by which a folder identifies its command."""

RESULTS = "results.json"  # of `calot run` and of `calot evaluate`
MANIFEST = "evaluation.json"  # of `calot evaluate` only
