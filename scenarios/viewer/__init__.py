"""Watch the procedure in a browser, and correct it."""
