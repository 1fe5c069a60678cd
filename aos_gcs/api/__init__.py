"""HTTP and WebSocket interface of the service, and the dashboard's files."""
