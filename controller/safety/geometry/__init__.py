"""How far are the instruments from each obstacle, and in which direction?"""
