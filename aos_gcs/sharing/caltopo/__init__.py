"""CalTopo and SARTopo: live positions, and findings, area and tracks on a map."""
