"""One vehicle that speaks MAVLink, whichever driver carries the packets.

| modules | |
|---|---|
| ``mavlink_vehicle`` | the vehicle port, put together from the rest |
| ``record``, ``telemetry``, ``status_text``, ``streams``, ``timesync`` | what is known and asked, without I/O |
| ``commands``, ``transaction``, ``waiting`` | a command, from the first packet to its effect |
| ``setup``, ``conversation``, ``parameters``, ``fence`` | settings and geofences, read and written |
| ``autopilots`` | the dialects of ArduCopter and PX4 |
| ``cameras`` | one capture, from each kind of source |
"""
