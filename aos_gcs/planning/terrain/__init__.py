"""The ground below plans: read from elevation models, checked against, and cleared by returns."""
