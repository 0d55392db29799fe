"""sindyna beside its peers in Python: what it is measured against, and the measuring."""
