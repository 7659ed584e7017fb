# PYTHON_ARGCOMPLETE_OK
"""Entry point of ``python -m fairaudit``."""

import sys

from fairaudit.cli import main

sys.exit(main())
