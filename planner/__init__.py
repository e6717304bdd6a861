"""What to do next, in a surgeon's words."""
