"""A report as a page; each section has its own file."""
