"""Words of the page that no run can measure: what a row does, and why ours is behind where it is (from profiles)."""

# By row.
NOTES = {}

# By key of a line; stated only where that line is behind.
REASONS = {}
