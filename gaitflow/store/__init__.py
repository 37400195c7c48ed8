"""The store of a run: units of work, their parts, attempts and journal; the truth that a run goes on from."""
