"""Who made a certificate, of which files, when: the statement beside a certificate, its signature, and the log counted again."""
