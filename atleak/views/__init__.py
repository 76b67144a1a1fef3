"""Make the records and rows of a result that pages, figures and reports share."""
