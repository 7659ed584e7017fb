"""Experiments with language models: ask, keep every answer, certify. Needs the extra ``vlm``."""
