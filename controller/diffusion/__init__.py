"""A diffusion policy over chunks of tool motions, conditioned on what is seen and on words."""
