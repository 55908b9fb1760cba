"""Files: what a user writes by hand, in and out, with one line that names file, key and reason for every fault."""
