"""Which tasks has a procedure, and when is each done? The procedure is data, in tables."""
