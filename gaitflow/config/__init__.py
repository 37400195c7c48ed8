"""What a user writes, as strict, frozen data: robots, scenarios, clusters; and the tasks of a scenario."""
