"""Pictures of stability: growth rates, borders, maps, branches, basins."""
