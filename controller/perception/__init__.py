"""Which observation follows from pictures, encoders and motor currents, without the world?"""
