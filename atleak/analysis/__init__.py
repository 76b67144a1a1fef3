"""Work out what follows from a diagnosis: repairs, comparisons, wear over mileage, what-if, learned clearances."""
