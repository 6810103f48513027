"""The text of a machine on the screen: its fields, edits of it, and what is wrong with it."""
