"""How far is the tissue from its converged static solution?"""
