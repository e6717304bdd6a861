"""What is read by rule, before the grammar: warnings, prohibitions, sizes, questions, dangers."""
