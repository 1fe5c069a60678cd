"""Cursor on Target, for ATAK, WinTAK, iTAK and TAK servers."""
