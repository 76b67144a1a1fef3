"""Choose repairs, put them in order and say what they bring."""
