"""What a rule asks to be published, from a certificate that was checked."""
