"""The first tables: no book is older than these."""

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Change nothing: a book without tables is made whole from their declaration."""
