"""The event stream: what clients have to know, and what waits to be sent to each."""
