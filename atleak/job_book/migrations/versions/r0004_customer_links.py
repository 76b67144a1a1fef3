"""The addresses at which a customer says yes or no to a job's repairs."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    moment = sa.DateTime(timezone=True)
    op.create_table(
        "customer_links",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("job", sa.String(32), sa.ForeignKey("jobs.id", ondelete="CASCADE"), nullable=False),
        sa.Column("token", sa.String(40), nullable=False, unique=True),
        sa.Column("made_at", moment, nullable=False),
        sa.Column("until", moment, nullable=False),
        sa.Column("closed_at", moment),
        sa.Column("screen", sa.LargeBinary, nullable=False),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("answered_at", moment),
        sa.Column("agreed", sa.Text, nullable=False),
    )
    op.create_index(op.f("ix_customer_links_job"), "customer_links", ["job"])
