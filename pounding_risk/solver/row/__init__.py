"""The row solver: any number of storey buildings in a row, and every contact between neighbours."""
