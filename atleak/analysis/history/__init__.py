"""See how a unit wears from several visits: rates, the mileage at which each limit is reached, the total over mileage.

`land_wear.wear_over_mileage` is the way through it: `visits` says what one visit tells, `series` which points of
a land count and which errors of measuring they share, `totals` what the whole unit will leak.
"""
