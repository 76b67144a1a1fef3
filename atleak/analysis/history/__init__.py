"""Work out from several visits how a unit wears: rates, mileages at which limits are reached, totals over mileage.

Begin at `wear.wear_over_mileage`. `series` says which measurements of a land count and which errors of measuring they
share; `wear.totals_over_mileage` says what the whole unit will leak.
"""
