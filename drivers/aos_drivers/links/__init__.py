"""Links, whatever the driver: sockets and serial lines, framing, routes, packet loss and the record of all traffic.

| modules | |
|---|---|
| ``address``, ``opener``, ``serial_port`` | from the text of a link to an open endpoint |
| ``framing``, ``heartbeat``, ``recorder`` | packets in a stream of bytes, heartbeats, and the ``.tlog`` on disk |
| ``routes``, ``identity``, ``loss`` | the address at which a vehicle is reached, and how well |
"""
