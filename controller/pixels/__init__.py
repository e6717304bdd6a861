"""Which motions does a diffusion policy sample from pictures, without perceived points?"""
