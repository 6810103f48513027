"""The same machine in AUTO-07p, an established program for continuation (Doedel et al. 2012), written independently."""
