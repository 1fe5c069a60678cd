"""The event stream: the state that clients know, and the messages that wait for each of them."""
