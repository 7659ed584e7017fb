"""What is audited: laws, utilities, privacy filters, policies, allocations."""
