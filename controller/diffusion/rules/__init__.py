"""Which rules on what is seen have the last word on a chunk of the diffusion policy?"""
