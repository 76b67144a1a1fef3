"""What the pages share: the job that is shown, the panel that changes it, and how results are shown."""
