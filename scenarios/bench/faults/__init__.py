"""Does anything hurt that is tampered with? Inputs are made from good ones by chance."""
