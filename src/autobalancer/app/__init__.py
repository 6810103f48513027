"""The bench on the screen: a web page that describes, checks and runs machines. It computes nothing itself."""
