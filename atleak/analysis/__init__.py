"""Say what follows from a diagnosis: repairs, comparisons, wear over mileage, trials, learned clearances."""
