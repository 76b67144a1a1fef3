"""See how a unit wears from several visits: rates, the mileage at which each limit is reached, the total over mileage.

`land_wear.wear_over_mileage` is the way through it: `visits` says what one visit tells, `shared_errors` which errors of
measuring two visits have in common, `series` which points of a land count, `totals` what the whole unit will leak.
"""
