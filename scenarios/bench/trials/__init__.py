"""What does a bench do to one patient? Attacks, storms, corrections and other trials."""
