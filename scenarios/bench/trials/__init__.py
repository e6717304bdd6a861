"""How does a bench examine a patient, or an input? By attacks, storms, faults and other trials.

Most files also have the table of their trials.
"""
