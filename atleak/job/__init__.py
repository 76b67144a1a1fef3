"""Turn files and choices into a diagnosis, and keep the whole job as one file."""
