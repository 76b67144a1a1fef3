"""Provide what the pages share: the job that is shown, the sidebar that changes it, and how results are shown."""
