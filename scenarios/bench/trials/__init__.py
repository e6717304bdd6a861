"""How does a bench examine a patient, or an input? By attacks, storms, faults and other trials."""
