"""Base maps of the dashboard, made of files that teams have and of the tiles of servers."""
