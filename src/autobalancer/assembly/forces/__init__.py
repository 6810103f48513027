"""Forces on balls: which acts on which, and whether each is what it says."""
