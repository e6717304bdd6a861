"""Which motions does a diffusion policy sample, from observations and words?"""
