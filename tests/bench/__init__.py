"""Speed, as ratios measured in one run: ``python -m tests.bench`` prints the table.

Everything runs in one thread; that is settled here, before NumPy is imported.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))
