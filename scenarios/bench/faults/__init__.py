"""Does tampered input do harm? Tampered inputs are random changes of good ones."""
