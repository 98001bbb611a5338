"""What is not a benchmark: tools that make constants, or that compare the code of two versions."""
