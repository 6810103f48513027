"""Balls in films and photographs: a camera that films a simulated race, and the way back from pictures to angles."""
