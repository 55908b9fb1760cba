"""Files: reading and writing the files of a user; an error is one line with file, key and reason."""
