"""The trials that benches repeat: attacks, storms, corrections and their like."""
