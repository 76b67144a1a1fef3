"""A table becomes the channels of a road test."""
