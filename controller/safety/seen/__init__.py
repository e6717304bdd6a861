"""Which obstacles, and which structures between the jaws, follow from the observation?"""
