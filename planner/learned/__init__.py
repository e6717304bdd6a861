"""Which instruction does a network give, from a history of observations?"""
