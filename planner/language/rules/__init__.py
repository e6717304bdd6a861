"""What is read by rule, before the grammar?"""
