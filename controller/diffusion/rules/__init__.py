"""Rules on what is seen that have the last word on a chunk: each in one direction, or to rest."""
