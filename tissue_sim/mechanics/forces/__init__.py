"""Which forces hold tissue together, and how stiff are they?"""
