"""What the pages share: the job on the bench, the panel that changes it, and how results are shown."""
