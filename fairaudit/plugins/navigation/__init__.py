"""From a scanned floor to the candidate routes that a decision maker is shown: scan in, pictures and routes out."""
