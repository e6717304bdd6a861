"""What exists in the operating field and how it moves."""
