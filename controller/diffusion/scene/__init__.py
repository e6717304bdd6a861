"""What of an observation does the policy take, and in which form?"""
