"""A report as a page: a section a file."""
