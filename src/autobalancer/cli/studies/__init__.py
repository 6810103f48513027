"""Commands that run studies and decide by them."""
