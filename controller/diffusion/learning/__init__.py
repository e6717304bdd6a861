"""How does the policy learn from demonstrations?"""
