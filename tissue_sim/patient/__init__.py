"""Which body is on the table, and which of its parts have a name?"""
