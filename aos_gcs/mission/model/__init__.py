"""The mission as others see it: frozen data by subject, such as phases, snapshots, steps, actions and events.

The API, the store and the tests read it. Positions are ENU metres about the mission's origin; ``origin`` in the
snapshot places them on the globe.
"""
