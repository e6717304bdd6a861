"""How do people act on a running episode?"""
