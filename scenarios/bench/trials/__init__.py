"""How does a bench examine one patient? By attacks, storms, corrections and other trials."""
