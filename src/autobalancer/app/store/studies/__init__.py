"""Studies and designs of a user: their files, runs that can be resumed, tables and pictures of what came out."""
