"""Tuning: from scores of flights to a tuned controller: metric, goal, objective, and the loop of ask, fly, tell."""
