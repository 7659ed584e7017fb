"""Reports that a person reads: a page, markdown, text; from a certificate or a result."""
