"""A diffusion policy end to end: from pictures, encoders and words, without perceived points."""
