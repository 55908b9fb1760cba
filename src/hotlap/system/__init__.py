"""System: the machine below us: disk cache, process pool, folder lock, journal, text files, threads of linear algebra."""
