"""The store of a run: units of work, their parts, attempts and journal. A run that goes on trusts only the store."""
