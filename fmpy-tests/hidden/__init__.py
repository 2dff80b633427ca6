"""Hidden effects: measured records of plants that the product has not seen, and a score of what it names. Start in run.py."""
