"""The study of missions: how often the claims of whole missions are right, what they cost, and how safe they are."""
