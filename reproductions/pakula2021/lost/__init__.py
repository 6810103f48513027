"""The machine that Pakuła (2021) does not print: a search over what is free, by all that the source says at once."""
