"""What plots of an output show."""
