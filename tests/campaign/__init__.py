"""Random missions with random faults, in virtual time: what must hold whatever happens.

A scenario is drawn from a seed (``scenario``): vehicles, errors of their sensors, and faults (``faults``). A mission of
the real driver and coordinator flies it over the tests' air (``world``, ``station``), an oracle that knows the truth
watches (``oracle``), and what fails is repeated without one fault after the other until only those are left that it
takes (``shrink``). ``python -m tests.campaign`` flies many, ``SEED=123`` one.
"""
