"""Certificates: written, read back, compared. The format is docs/certificate.md."""
