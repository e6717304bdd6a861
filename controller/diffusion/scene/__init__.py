"""What of an observation do policy and rules take?"""
