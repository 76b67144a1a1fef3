"""See how a unit wears from several visits: rates, the mileage at which each limit is reached, the total over mileage.

`wear.wear_over_mileage` is the way through it: `series` says what one visit tells, which points of a land count and
which errors of measuring they share, `wear.totals_over_mileage` what the whole unit will leak.
"""
