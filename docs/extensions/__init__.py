"""What hotlap's documentation has beyond Sphinx: each page's placeholders are filled from the code itself."""
