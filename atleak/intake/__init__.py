"""Outside files become readings and road tests here; the only rooms that guess and that convert units."""
