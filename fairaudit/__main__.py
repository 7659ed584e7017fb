"""Entry point of ``python -m fairaudit``."""
# PYTHON_ARGCOMPLETE_OK

import sys

from fairaudit.cli import main

sys.exit(main())
