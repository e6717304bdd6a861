"""By which panels does a person act on the episode?"""
