"""How do clips latch, squeeze, slip and fall?"""
