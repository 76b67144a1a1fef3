"""What gauge readings of a standing vehicle say: each against what is permissible and expected, and their patterns."""
