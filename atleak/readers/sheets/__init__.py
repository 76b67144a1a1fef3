"""Read measuring sheets as workshops lay them out."""
