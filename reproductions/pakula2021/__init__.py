"""Pakuła (2021): the automatic ball balancer with a deep chamber."""
