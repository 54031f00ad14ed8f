"""``python -m analysis.wild PACKAGE [METHOD] STEP``: an adapter as a program for the judge."""

import sys
from importlib import import_module

from longball.judge import serve

package, *method, step = sys.argv[1:]
fly = import_module(f"analysis.wild.adapters.{package}").fly
serve(lambda state, p: fly(state, p, "".join(method), float(step)))
