"""Which facts of an observation do policy and rules use?"""
