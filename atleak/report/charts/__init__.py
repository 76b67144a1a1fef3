"""Say each chart once; draw it on the screen and on paper."""
