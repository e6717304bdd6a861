"""The planner that is learned: from a history of observations to what should be said next."""
