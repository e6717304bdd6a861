"""How do episodes run in parallel, on one machine or on a cluster?"""
