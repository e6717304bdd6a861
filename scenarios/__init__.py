"""Put together, run, judge."""
