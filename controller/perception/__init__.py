"""What is seen in pictures, with encoders and motor currents? An observation; it knows no world."""
