"""Plug-ins: suppliers of policies and commands. The core never imports them, and they never import each other."""
