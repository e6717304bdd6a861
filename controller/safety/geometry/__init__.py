"""Which distance and direction have the instruments from each obstacle?"""
