"""Which benches can `calot bench` run?"""
