"""System: what the machine provides: disk cache, process pool, folder lock, journal, processors, text files, threads of linear algebra."""
