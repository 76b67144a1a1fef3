"""Diagnose thousands of units on many processes, keep their results as Parquet, and summarise them."""
