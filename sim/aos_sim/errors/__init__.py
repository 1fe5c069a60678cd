"""The simulator's one error model: a module per kind of error, their grades in ``model`` (docs/simulator.md)."""
