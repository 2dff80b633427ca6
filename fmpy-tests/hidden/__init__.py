"""Hidden effects: measured records of plants unknown to the product, and a score of the effects that it names. Start in run.py."""
