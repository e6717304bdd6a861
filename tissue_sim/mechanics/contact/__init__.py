"""What does tissue touch, and with which force?"""
