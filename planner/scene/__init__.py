"""Which facts follow from the observation alone?"""
